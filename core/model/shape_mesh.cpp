#include "core/model/shape_mesh.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/mesh_topology.h"

namespace vitrine {

namespace {

TriMesh smooth_shaded(TriMesh mesh) {
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

double corner_angle(const Vec3d& at, const Vec3d& a, const Vec3d& b) {
  const Vec3d u = a - at, v = b - at;
  return std::atan2(length(cross(u, v)), dot(u, v));
}

std::array<int, 3> cell_of(const Vec3f& p, float size) {
  constexpr float kFarthest = 1 << 20;  // what lies beyond shares a cell
  const auto along = [&](float x) { return int(std::floor(std::fmax(-kFarthest, std::fmin(x / size, kFarthest)))); };
  return {along(p.x), along(p.y), along(p.z)};
}
uint64_t key(const std::array<int, 3>& cell) {
  constexpr uint64_t kBits = 21, kMask = (1u << kBits) - 1;
  return ((uint64_t(cell[0]) & kMask) << (2 * kBits)) | ((uint64_t(cell[1]) & kMask) << kBits) | (uint64_t(cell[2]) & kMask);
}

}  // namespace

ShapeMesh::ShapeMesh(TriMesh mesh, float tolerance) : mesh_(smooth_shaded(std::move(mesh))), tolerance_(tolerance), hits_(mesh_) {
  VITRINE_CHECK(tolerance > 0, "surfels lie near the mesh that they show");
  for (uint32_t v = 0; v < mesh_.positions.size(); ++v) cells_.emplace_back(key(cell_of(mesh_.positions[v], tolerance_)), v);
  std::ranges::sort(cells_);
}

std::optional<Vec3f> ShapeMesh::near(const Vec3f& place) const {
  const std::array<int, 3> middle = cell_of(place, tolerance_);
  float best = tolerance_ * tolerance_;
  std::optional<Vec3f> normal;
  for (int n = 0; n < 27; ++n) {
    const uint64_t wanted = key({middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1});
    for (auto it = std::ranges::lower_bound(cells_, std::pair{wanted, 0u}); it != cells_.end() && it->first == wanted; ++it)
      if (const float d = squared_length(mesh_.positions[it->second] - place); d <= best)
        best = d, normal = mesh_.normals[it->second];
  }
  return normal;
}

std::optional<ShapeMesh::Entry> ShapeMesh::entry(const Vec3f& eye, const Vec3f& direction) const {
  const auto hit = hits_.first_face(eye, direction);
  if (!hit || hit->from_inside) return std::nullopt;
  const auto& f = mesh_.faces[hit->face];
  const Vec3f n = (1 - hit->u - hit->v) * mesh_.normals[f[0]] + hit->u * mesh_.normals[f[1]] + hit->v * mesh_.normals[f[2]];
  if (!(squared_length(n) > 0)) return std::nullopt;
  return Entry{hit->t, normalized(n), hit->face, hit->u, hit->v};
}

// A normal turns against the slope of the displacement, dn = -grad(delta). That of a vertex is the mean over its faces by their
// corner angles, as the normal is; grad(phi) of a corner is N x (opposite edge) / (2 area).
MeshSlopes::MeshSlopes(const TriMesh& mesh)
    : mesh_(mesh), first_(mesh.positions.size() + 1, 0), angle_sum_(mesh.positions.size(), 0.0) {
  for (const auto& f : mesh.faces)
    for (uint32_t v : f) ++first_[v + 1];
  for (size_t v = 0; v < mesh.positions.size(); ++v) first_[v + 1] += first_[v];
  corners_.resize(first_.back());
  std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
  for (uint32_t f = 0; f < mesh.faces.size(); ++f)
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t v = mesh.faces[f][c];
      const double angle = corner_angle(at(v), at(mesh.faces[f][(c + 1) % 3]), at(mesh.faces[f][(c + 2) % 3]));
      corners_[next[v]++] = {f, angle};
      angle_sum_[v] += angle;
    }
}

void MeshSlopes::add(const ShapeMesh::Entry& hit, const Vec3d& grad_normal, double grad_offset, std::vector<double>& grad) const {
  const std::array<double, 3> weight{1 - double(hit.u) - double(hit.v), double(hit.u), double(hit.v)};
  for (size_t c = 0; c < 3; ++c) {
    const uint32_t v = mesh_.faces[hit.face][c];
    grad[v] += weight[c] * grad_offset;
    for (uint32_t k = first_[v]; k < first_[v + 1]; ++k) {
      const auto& f = mesh_.faces[corners_[k].face];
      const Vec3d n2 = cross(at(f[1]) - at(f[0]), at(f[2]) - at(f[0]));  // 2 area long
      const double squared = dot(n2, n2);
      if (!(squared > 0)) continue;
      const double share = weight[c] * corners_[k].angle / angle_sum_[v];
      for (size_t j = 0; j < 3; ++j)
        grad[f[j]] -= share * dot(grad_normal, cross(n2, at(f[(j + 2) % 3]) - at(f[(j + 1) % 3]))) / squared;
    }
  }
}

}  // namespace vitrine
