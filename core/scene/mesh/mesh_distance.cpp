#include "core/scene/mesh/mesh_distance.h"

#include <algorithm>
#include <limits>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"

namespace vitrine {

namespace {

constexpr uint32_t kLeafSize = 4;

Vec3f lower(const Vec3f& a, const Vec3f& b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3f upper(const Vec3f& a, const Vec3f& b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

float squared_distance_to_box(const Vec3f& p, const Vec3f& low, const Vec3f& high) {
  float sum = 0;
  for (size_t i = 0; i < 3; ++i) {
    const float d = std::max({low[i] - p[i], 0.f, p[i] - high[i]});
    sum += d * d;
  }
  return sum;
}

Vec3f closest_on_segment(const Vec3f& p, const Vec3f& a, const Vec3f& b) {
  const Vec3f ab = b - a;
  const float squared = squared_length(ab);
  const float t = squared > 0 ? std::clamp(dot(p - a, ab) / squared, 0.f, 1.f) : 0.f;
  return a + t * ab;
}

// Projection onto the plane if it is inside the triangle, else the nearest point on the three sides.
Vec3f closest_on_triangle(const Vec3f& p, const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3f ab = b - a, ac = c - a, ap = p - a;
  const Vec3f n = cross(ab, ac);
  const float squared = squared_length(n);
  if (squared > 0) {
    const float v = dot(cross(ap, ac), n), w = dot(cross(ab, ap), n);  // barycentric coordinates of b and c, times |n|^2
    if (v >= 0 && w >= 0 && v + w <= squared) return p - (dot(ap, n) / squared) * n;
  }
  const Vec3f candidates[3] = {closest_on_segment(p, a, b), closest_on_segment(p, b, c), closest_on_segment(p, c, a)};
  const Vec3f* best = &candidates[0];
  for (const Vec3f& q : candidates)
    if (squared_length(p - q) < squared_length(p - *best)) best = &q;
  return *best;
}

}  // namespace

SurfaceSamples sample_surface(const TriMesh& mesh, size_t n, uint64_t seed) {
  std::vector<double> cumulated(mesh.faces.size());
  double total = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& [i, j, k] = mesh.faces[f];
    const Vec3d a = cast<double>(mesh.positions[i]);
    total += 0.5 * length(cross(cast<double>(mesh.positions[j]) - a, cast<double>(mesh.positions[k]) - a));
    cumulated[f] = total;
  }
  SurfaceSamples samples;
  if (!(total > 0)) return samples;
  samples.positions.resize(n);
  samples.normals.resize(n);
  samples.faces.resize(n);
  parallel_for(n, 4096, [&](size_t s) {
    Rng rng(seed, s);
    const double along = total * ((static_cast<double>(s) + rng.uniform_double()) / static_cast<double>(n));
    auto found = std::upper_bound(cumulated.begin(), cumulated.end(), along);  // skips faces of zero area
    if (found == cumulated.end()) found = std::lower_bound(cumulated.begin(), cumulated.end(), total);
    const size_t f = static_cast<size_t>(found - cumulated.begin());
    const auto& [i, j, k] = mesh.faces[f];
    const Vec3f &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
    const float r = std::sqrt(rng.uniform()), t = rng.uniform();  // uniform in the triangle
    samples.positions[s] = (1 - r) * a + (r * (1 - t)) * b + (r * t) * c;
    samples.normals[s] = cast<float>(normalized(cross(cast<double>(b - a), cast<double>(c - a))));
    samples.faces[s] = static_cast<uint32_t>(f);
  });
  return samples;
}

MeshDistance::MeshDistance(const TriMesh& mesh) {
  VITRINE_CHECK(mesh.faces.size() < std::numeric_limits<uint32_t>::max(), "too many faces");
  triangles_.reserve(mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const auto& [i, j, k] = mesh.faces[f];
    triangles_.push_back({mesh.positions[i], mesh.positions[j], mesh.positions[k], static_cast<uint32_t>(f)});
  }
  if (triangles_.empty()) return;
  const auto centroid = [](const Triangle& t, size_t axis) { return t.a[axis] + t.b[axis] + t.c[axis]; };
  nodes_.push_back({{}, {}, 0, static_cast<uint32_t>(triangles_.size())});
  for (size_t n = 0; n < nodes_.size(); ++n) {
    const uint32_t begin = nodes_[n].begin, count = nodes_[n].count;
    Vec3f low = triangles_[begin].a, high = low;
    for (uint32_t i = begin; i < begin + count; ++i) {
      low = lower(lower(low, triangles_[i].a), lower(triangles_[i].b, triangles_[i].c));
      high = upper(upper(high, triangles_[i].a), upper(triangles_[i].b, triangles_[i].c));
    }
    nodes_[n].low = low;
    nodes_[n].high = high;
    if (count <= kLeafSize) continue;
    const Vec3f side = high - low;
    const size_t axis = side.x >= side.y ? (side.x >= side.z ? 0 : 2) : (side.y >= side.z ? 1 : 2);
    const uint32_t half = count / 2;
    std::nth_element(triangles_.begin() + begin, triangles_.begin() + begin + half, triangles_.begin() + begin + count,
                     [&](const Triangle& s, const Triangle& t) {
                       const float cs = centroid(s, axis), ct = centroid(t, axis);
                       return cs != ct ? cs < ct : s.face < t.face;
                     });
    nodes_[n].begin = static_cast<uint32_t>(nodes_.size());
    nodes_[n].count = 0;
    nodes_.push_back({{}, {}, begin, half});
    nodes_.push_back({{}, {}, begin + half, count - half});
  }
}

ClosestPoint MeshDistance::closest(const Vec3f& p) const {
  VITRINE_CHECK(!empty(), "closest point of an empty mesh");
  struct Waiting {
    uint32_t node;
    float squared;
  };
  Waiting stack[64];  // median splits: depth <= 32
  int top = 0;
  stack[top++] = {0, squared_distance_to_box(p, nodes_[0].low, nodes_[0].high)};
  float best = std::numeric_limits<float>::infinity();
  ClosestPoint result;
  while (top > 0) {
    const Waiting w = stack[--top];
    if (w.squared > best) continue;
    const Node& node = nodes_[w.node];
    for (uint32_t i = node.begin; i < node.begin + node.count; ++i) {
      const Triangle& t = triangles_[i];
      const Vec3f q = closest_on_triangle(p, t.a, t.b, t.c);
      const float squared = squared_length(p - q);
      if (squared < best || (squared == best && t.face < result.face)) {
        best = squared;
        result.position = q;
        result.face = t.face;
      }
    }
    if (node.count > 0) continue;
    Waiting near{node.begin, squared_distance_to_box(p, nodes_[node.begin].low, nodes_[node.begin].high)};
    Waiting far{node.begin + 1, squared_distance_to_box(p, nodes_[node.begin + 1].low, nodes_[node.begin + 1].high)};
    if (far.squared < near.squared) std::swap(near, far);
    stack[top++] = far;
    stack[top++] = near;
  }
  result.distance = std::sqrt(best);
  return result;
}

std::vector<float> MeshDistance::distances(std::span<const Vec3f> points) const {
  std::vector<float> out(points.size(), std::numeric_limits<float>::infinity());
  if (empty()) return out;
  parallel_for(points.size(), 1024, [&](size_t i) { out[i] = closest(points[i]).distance; });
  return out;
}

}  // namespace vitrine
