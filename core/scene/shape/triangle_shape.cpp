#include "core/scene/shape/triangle_shape.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <mutex>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/scene/mesh/mesh_distance.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/mesh/mesh_hits.h"

namespace vitrine {

namespace {

constexpr double kGrazing = 0.05;        // minimum cosine to the ray: at grazing angles t is ill-conditioned
constexpr int kVertexMixing = 20;        // smoothing passes: half a vertex, half its neighbours
constexpr double kVertexStep_rel = 0.5;  // relative to the length steps of other shapes

TriMesh smooth_shaded(TriMesh mesh) {
  VITRINE_CHECK(!mesh.faces.empty(), "a shape has a surface");
  for (const auto& f : mesh.faces)
    for (const uint32_t v : f)
      if (v >= mesh.positions.size())
        throw Error(ErrorKind::Input, "a face of a shape names a vertex that does not exist",
                    {.why = fmt::format("vertex {} of {}", v, mesh.positions.size()),
                     .hint = "compute the stage that wrote the mesh anew",
                     .code = "BAD_MESH"});
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

double corner_angle(const Vec3d& at, const Vec3d& a, const Vec3d& b) {
  const Vec3d u = a - at, v = b - at;
  return std::atan2(length(cross(u, v)), dot(u, v));
}

// Mesh connectivity, independent of the vertex positions: faces and neighbours of each vertex.
struct Topology {
  std::vector<uint32_t> first_corner, corners;  // [vertex + 1], faces
  VertexNeighbours neighbours;

  explicit Topology(const TriMesh& mesh) : first_corner(mesh.positions.size() + 1, 0), neighbours(mesh) {
    for (const auto& f : mesh.faces)
      for (const uint32_t v : f) ++first_corner[v + 1];
    for (size_t v = 0; v < mesh.positions.size(); ++v) first_corner[v + 1] += first_corner[v];
    corners.resize(first_corner.back());
    std::vector<uint32_t> next(first_corner.begin(), first_corner.end() - 1);
    for (uint32_t f = 0; f < mesh.faces.size(); ++f)
      for (const uint32_t v : mesh.faces[f]) corners[next[v]++] = f;
  }
};

// Corner angles of the faces around the vertices.
struct Angles {
  std::vector<double> corner, sum;  // [Topology::corners], [vertex]

  Angles(const TriMesh& mesh, const Topology& topology) : corner(topology.corners.size()), sum(mesh.positions.size(), 0.0) {
    const auto at = [&](uint32_t v) { return cast<double>(mesh.positions[v]); };
    for (uint32_t v = 0; v < sum.size(); ++v)
      for (uint32_t k = topology.first_corner[v]; k < topology.first_corner[v + 1]; ++k) {
        const auto& f = mesh.faces[topology.corners[k]];
        const size_t c = f[0] == v ? 0 : f[1] == v ? 1 : 2;
        sum[v] += corner[k] = corner_angle(at(v), at(f[(c + 1) % 3]), at(f[(c + 2) % 3]));
      }
  }
};

template <class T>
class MadeOnce {
 public:
  template <class... Args>
  const T& get(const Args&... args) const {
    std::call_once(made_, [&] { value_ = std::make_unique<T>(args...); });
    return *value_;
  }

 private:
  mutable std::once_flag made_;
  mutable std::unique_ptr<T> value_;
};

}  // namespace

// Lazily built data.
struct TriangleShape::State {
  using SharedTopology = std::shared_ptr<const MadeOnce<Topology>>;
  State(TriMesh m, SharedTopology t) : mesh(smooth_shaded(std::move(m))), hits(mesh), topology_(std::move(t)) {}
  const MeshDistance& distance() const { return distance_.get(mesh); }
  const Topology& topology() const { return topology_->get(mesh); }
  const Angles& angles() const { return angles_.get(mesh, topology()); }
  const SharedTopology& shared_topology() const { return topology_; }
  Vec3d at(uint32_t vertex) const { return cast<double>(mesh.positions[vertex]); }

  TriMesh mesh;
  MeshHits hits;

 private:
  SharedTopology topology_;  // shared by moved meshes
  MadeOnce<MeshDistance> distance_;
  MadeOnce<Angles> angles_;
};

TriangleShape::TriangleShape(TriMesh mesh)
    : state_(std::make_shared<State>(std::move(mesh), std::make_shared<const MadeOnce<Topology>>())) {}

const TriMesh& TriangleShape::mesh() const { return state_->mesh; }

std::optional<ShapeHit> TriangleShape::intersect(const Ray& ray) const {
  const TriMesh& m = state_->mesh;
  const auto hit = state_->hits.first_face(cast<float>(ray.origin), cast<float>(ray.direction));
  if (!hit || hit->from_inside) return std::nullopt;
  const auto& f = m.faces[hit->face];
  const Vec3f n = (1 - hit->u - hit->v) * m.normals[f[0]] + hit->u * m.normals[f[1]] + hit->v * m.normals[f[2]];
  if (!(squared_length(n) > 0)) return std::nullopt;
  return ShapeHit{double(hit->t), cast<double>(normalized(n)), hit->face, {double(hit->u), double(hit->v)}};
}

ShapePoint TriangleShape::nearest(const Vec3d& p) const {
  const ClosestPoint closest = state_->distance().closest(cast<float>(p));
  const auto& f = state_->mesh.faces[closest.face];
  const Vec3d q = cast<double>(closest.position), a = state_->at(f[0]), b = state_->at(f[1]), c = state_->at(f[2]);
  const Vec3d n = cross(b - a, c - a);
  Vec3d blended{};  // weighted by the areas opposite to the corners
  for (const auto& [u, v, k] : {std::tuple{b, c, 0}, {c, a, 1}, {a, b, 2}})
    blended += std::max(dot(cross(u - q, v - q), n), 0.0) * cast<double>(state_->mesh.normals[f[size_t(k)]]);
  return {q, normalized(squared_length(blended) > 0 ? blended : cast<double>(state_->mesh.normals[f[0]]))};
}

std::vector<Vec3d> TriangleShape::outer_points() const {
  std::vector<Vec3d> out;
  for (const Vec3f& p : state_->mesh.positions) out.push_back(cast<double>(p));
  return out;
}

double TriangleShape::size() const {
  Bounds3 bounds;
  for (const Vec3f& p : state_->mesh.positions) bounds.extend(cast<double>(p));
  return bounds.diagonal();
}

std::vector<ParameterGroup> TriangleShape::parameters() const {
  return {{state_->mesh.positions.size(), ParameterUnit::Length, kVertexStep_rel}};
}

// A displacement delta changes the normal by dn = -grad(delta). A vertex uses the mean over its faces weighted by corner
// angles, like its normal; grad(phi) of a corner is N x (opposite edge) / (2 area).
void TriangleShape::hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const {
  const Topology& around = state_->topology();
  const Angles& angles = state_->angles();
  const Vec3d& n = hit.normal;
  const Vec3d along = grad.normal - dot(grad.normal, n) * n;
  const double offset = grad.t / std::min(dot(n, ray.direction), -kGrazing * length(ray.direction));
  const std::array<double, 3> weight{1 - hit.at.x - hit.at.y, hit.at.x, hit.at.y};
  for (size_t c = 0; c < 3; ++c) {
    const uint32_t v = state_->mesh.faces[hit.element][c];
    out[v] += weight[c] * offset;
    for (uint32_t k = around.first_corner[v]; k < around.first_corner[v + 1]; ++k) {
      const auto& f = state_->mesh.faces[around.corners[k]];
      const std::array<Vec3d, 3> p{state_->at(f[0]), state_->at(f[1]), state_->at(f[2])};
      const Vec3d n2 = cross(p[1] - p[0], p[2] - p[0]);  // length = 2 * area
      const double squared = dot(n2, n2);
      if (!(squared > 0)) continue;
      const double share = weight[c] * angles.corner[k] / angles.sum[v];
      for (size_t j = 0; j < 3; ++j) out[f[j]] -= share * dot(along, cross(n2, p[(j + 2) % 3] - p[(j + 1) % 3])) / squared;
    }
  }
}

void TriangleShape::place_vjp(const ShapeHit& hit, const Vec3d&, const Vec3d& grad, std::span<double> out) const {
  const std::array<double, 3> weight{1 - hit.at.x - hit.at.y, hit.at.x, hit.at.y};
  for (size_t c = 0; c < 3; ++c) {
    const uint32_t v = state_->mesh.faces[hit.element][c];
    out[v] += weight[c] * dot(grad, cast<double>(state_->mesh.normals[v]));
  }
}

void TriangleShape::smooth(std::span<double> slope) const {
  const VertexNeighbours& neighbours = state_->topology().neighbours;
  for (int pass = 0; pass < kVertexMixing; ++pass) {
    const std::vector<double> before(slope.begin(), slope.end());
    for (size_t v = 0; v < slope.size(); ++v) {
      const auto around = neighbours.of(v);
      if (around.empty()) continue;
      double sum = 0;
      for (const uint32_t o : around) sum += before[o];
      slope[v] = 0.5 * (before[v] + sum / double(around.size()));
    }
  }
}

TriangleShape TriangleShape::moved(std::span<const double> step) const {
  TriMesh mesh = state_->mesh;
  for (size_t v = 0; v < mesh.positions.size(); ++v) mesh.positions[v] += static_cast<float>(step[v]) * mesh.normals[v];
  TriangleShape out = *this;
  out.state_ = std::make_shared<State>(std::move(mesh), state_->shared_topology());
  return out;
}

}  // namespace vitrine
