#include "sample_data/generate/shape.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"

namespace vitrine::generate {
namespace {

TriMesh grid(const Vec3f& corner, const Vec3f& edge_u, const Vec3f& edge_v, uint32_t nu, uint32_t nv, std::vector<Vec2f>& uv) {
  TriMesh mesh;
  const Vec3f n = normalized(cross(edge_u, edge_v));
  const float length_u = length(edge_u), length_v = length(edge_v);
  for (uint32_t j = 0; j <= nv; ++j)
    for (uint32_t i = 0; i <= nu; ++i) {
      const float s = static_cast<float>(i) / static_cast<float>(nu), t = static_cast<float>(j) / static_cast<float>(nv);
      mesh.positions.push_back(corner + s * edge_u + t * edge_v);
      mesh.normals.push_back(n);
      uv.push_back({s * length_u, t * length_v});
    }
  for (uint32_t j = 0; j < nv; ++j)
    for (uint32_t i = 0; i < nu; ++i) {
      const uint32_t a = j * (nu + 1) + i, b = a + 1, c = a + nu + 1, d = c + 1;
      mesh.faces.push_back({a, b, d});
      mesh.faces.push_back({a, d, c});
    }
  return mesh;
}

Vec3f gradient(const DistanceFunction& distance, const Vec3f& p, float h) {
  return (0.5f / h) * Vec3f{distance(p + Vec3f{h, 0, 0}) - distance(p - Vec3f{h, 0, 0}),
                            distance(p + Vec3f{0, h, 0}) - distance(p - Vec3f{0, h, 0}),
                            distance(p + Vec3f{0, 0, h}) - distance(p - Vec3f{0, 0, h})};
}

}  // namespace

void append(TriMesh& to, const TriMesh& from) {
  const uint32_t base = static_cast<uint32_t>(to.positions.size());
  to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
  to.normals.insert(to.normals.end(), from.normals.begin(), from.normals.end());
  for (const auto& f : from.faces) to.faces.push_back({f[0] + base, f[1] + base, f[2] + base});
}

void append(Shape& to, const Shape& from) {
  append(to.mesh, from.mesh);
  to.uv.insert(to.uv.end(), from.uv.begin(), from.uv.end());
}

Shape rectangle(const Vec3f& corner, const Vec3f& edge_u, const Vec3f& edge_v, float cell) {
  const auto steps = [cell](float length) { return static_cast<uint32_t>(std::max(1.0f, std::ceil(length / cell - 1e-3f))); };
  Shape shape;
  shape.mesh = grid(corner, edge_u, edge_v, steps(length(edge_u)), steps(length(edge_v)), shape.uv);
  return shape;
}

Shape turned_box(const Vec3f& centre, const Vec3f& size, float angle, float cell) {
  const Vec3f x = size.x * Vec3f{std::cos(angle), std::sin(angle), 0};
  const Vec3f y = size.y * Vec3f{-std::sin(angle), std::cos(angle), 0};
  const Vec3f z{0, 0, size.z};
  const Vec3f low = centre - 0.5f * (x + y + z), high = centre + 0.5f * (x + y + z);
  Shape shape;
  float side = 0;
  for (Shape face : {rectangle(low + z, x, y, cell), rectangle(low, y, x, cell), rectangle(low, x, z, cell),
                     rectangle(low + x, y, z, cell), rectangle(high - z, -x, z, cell), rectangle(low + y, -y, z, cell)}) {
    for (Vec2f& uv : face.uv) uv = uv + side * Vec2f{3.1f, 5.3f};  // another piece of the pattern on every side
    side += 1;
    append(shape, face);
  }
  return shape;
}

Shape box(const Vec3f& low, const Vec3f& high, float cell) { return turned_box(0.5f * (low + high), high - low, 0, cell); }

Shape meshed(const DistanceFunction& distance, const Bounds3& bounds, float cell) {
  const Vec3f low = cast<float>(bounds.low);
  const auto points = [cell](double extent) { return static_cast<size_t>(std::ceil(extent / static_cast<double>(cell))) + 1; };
  const size_t nx = points(bounds.high.x - bounds.low.x), ny = points(bounds.high.y - bounds.low.y),
               nz = points(bounds.high.z - bounds.low.z);
  const auto at = [&](size_t i, size_t j, size_t k) { return (k * ny + j) * nx + i; };
  std::vector<float> value(nx * ny * nz);
  parallel_for(nz, 1, [&](size_t k) {
    for (size_t j = 0; j < ny; ++j)
      for (size_t i = 0; i < nx; ++i)
        value[at(i, j, k)] = distance(low + cell * Vec3f{static_cast<float>(i), static_cast<float>(j), static_cast<float>(k)});
  });

  constexpr uint32_t kNone = 0xffffffffu;
  std::vector<uint32_t> vertex_of_cell(value.size(), kNone);
  Shape shape;
  for (size_t k = 0; k + 1 < nz; ++k)
    for (size_t j = 0; j + 1 < ny; ++j)
      for (size_t i = 0; i + 1 < nx; ++i) {
        // The vertex of a cell is the mean of the zero crossings on its twelve edges.
        Vec3f sum{};
        float crossings = 0;
        for (size_t axis = 0; axis < 3; ++axis)
          for (size_t side = 0; side < 4; ++side) {
            size_t a[3] = {i, j, k};
            a[(axis + 1) % 3] += side & 1;
            a[(axis + 2) % 3] += side >> 1;
            size_t b[3] = {a[0], a[1], a[2]};
            b[axis] += 1;
            const float va = value[at(a[0], a[1], a[2])], vb = value[at(b[0], b[1], b[2])];
            if ((va < 0) == (vb < 0)) continue;
            Vec3f p{static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])};
            p[axis] += va / (va - vb);
            sum += p;
            crossings += 1;
          }
        if (crossings == 0) continue;
        vertex_of_cell[at(i, j, k)] = static_cast<uint32_t>(shape.mesh.positions.size());
        shape.mesh.positions.push_back(low + (cell / crossings) * sum);
      }

  // One quad around every grid edge whose ends have different signs, wound so that its normal points to the positive end.
  for (size_t k = 1; k + 1 < nz; ++k)
    for (size_t j = 1; j + 1 < ny; ++j)
      for (size_t i = 1; i + 1 < nx; ++i)
        for (size_t axis = 0; axis < 3; ++axis) {
          size_t end[3] = {i, j, k};
          end[axis] += 1;
          const bool inside = value[at(i, j, k)] < 0;
          if (inside == (value[at(end[0], end[1], end[2])] < 0)) continue;
          uint32_t corner[4];
          for (size_t c = 0; c < 4; ++c) {
            size_t q[3] = {i, j, k};
            q[(axis + 1) % 3] -= c == 0 || c == 3;
            q[(axis + 2) % 3] -= c == 0 || c == 1;
            corner[c] = vertex_of_cell[at(q[0], q[1], q[2])];
            VITRINE_CHECK(corner[c] != kNone, "surface net without a vertex beside a sign change");
          }
          if (!inside) std::swap(corner[1], corner[3]);
          shape.mesh.faces.push_back({corner[0], corner[1], corner[2]});
          shape.mesh.faces.push_back({corner[0], corner[2], corner[3]});
        }

  const size_t n = shape.mesh.positions.size();
  shape.mesh.normals.resize(n);
  shape.uv.assign(n, Vec2f{});
  parallel_for(n, 256, [&](size_t v) {
    Vec3f& p = shape.mesh.positions[v];
    const Vec3f start = p;
    for (int step = 0; step < 4; ++step) {
      const Vec3f g = gradient(distance, p, 0.1f * cell);
      p -= (distance(p) / std::max(squared_length(g), 1e-4f)) * g;
    }
    // A crease can throw the step far away; the net's own vertex is then the better one.
    if (!(length(p - start) < 0.75f * cell)) p = start;
    shape.mesh.normals[v] = normalized(gradient(distance, p, 0.25f * cell));
  });
  return shape;
}

float ellipsoid_distance(const Vec3f& p, const Vec3f& centre, const Vec3f& radii) {
  const Vec3f q = p - centre;
  const Vec3f a{q.x / radii.x, q.y / radii.y, q.z / radii.z};
  const Vec3f b{a.x / radii.x, a.y / radii.y, a.z / radii.z};
  const float k0 = length(a), k1 = length(b);
  return k1 < 1e-6f ? -std::min({radii.x, radii.y, radii.z}) : k0 * (k0 - 1.0f) / k1;
}

float capsule_distance(const Vec3f& p, const Vec3f& a, const Vec3f& b, float radius_a, float radius_b) {
  const Vec3f ab = b - a;
  const float t = std::clamp(dot(p - a, ab) / squared_length(ab), 0.0f, 1.0f);
  return length(p - a - t * ab) - std::lerp(radius_a, radius_b, t);
}

float torus_distance(const Vec3f& p, const Vec3f& centre, const Vec3f& axis, float ring, float tube) {
  const Vec3f q = p - centre;
  const float along = dot(q, axis);
  const float around = length(q - along * axis) - ring;
  return std::sqrt(around * around + along * along) - tube;
}

float smooth_union(float a, float b, float k) {
  const float h = std::max(k - std::abs(a - b), 0.0f);
  return std::min(a, b) - 0.25f * h * h / k;
}

}  // namespace vitrine::generate
