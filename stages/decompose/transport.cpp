#include "stages/decompose/transport.h"

#include <cmath>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/kd_tree.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/render/model/kernels/fresnel.h"
#include "core/scene/mesh/mesh_hits.h"

namespace vitrine {

namespace {

constexpr float kClear = 0.5f;   // minimum transmission of surfaces that rays pass
constexpr int kMaxPanes = 8;     // per ray
constexpr size_t kChunk = 64;    // points
constexpr size_t kBlock = 4096;  // points per progress report

// Barycentric weights of a point in a face.
Vec3f corner_weights(const TriMesh& mesh, uint32_t face, const Vec3f& p) {
  const auto& [i, j, k] = mesh.faces[face];
  const Vec3f &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
  const Vec3f n = cross(b - a, c - a);
  const float area = squared_length(n);
  if (!(area > 0)) return {1, 0, 0};
  const float u = dot(cross(c - b, p - b), n) / area, v = dot(cross(a - c, p - c), n) / area;
  return {u, v, 1 - u - v};
}

Vec3f color_at(const TriMesh& mesh, uint32_t face, const Vec3f& p) {
  const Vec3f w = corner_weights(mesh, face, p);
  Vec3f sum{};
  for (size_t c = 0; c < 3; ++c) sum += w[c] * mesh.colors[mesh.faces[face][c]];
  return {std::max(0.f, sum.x), std::max(0.f, sum.y), std::max(0.f, sum.z)};
}

class Rays {
 public:
  explicit Rays(const TransportScene& scene) : scene_(scene), mesh_(scene.mesh) {
    if (!scene.shell.faces.empty()) shell_.emplace(scene.shell);
  }

  // Ray origin of a point: on the front of the nearest mesh face along its normal.
  Vec3f start(const LitPoint& point, const TransportDesc& desc) const {
    constexpr int kMostSheets = 4;
    const Vec3f above = point.position + desc.reach * point.normal;
    float near = 0, best = desc.reach;  // distance below `above`; without a hit the point itself
    float miss = desc.reach;
    for (int sheet = 0; sheet < kMostSheets; ++sheet) {
      const std::optional<MeshHit> hit = mesh_.first_hit(above, -point.normal, near, 2 * desc.reach);
      if (!hit) break;
      if (!hit->from_inside && std::abs(hit->t - desc.reach) < miss) {
        best = hit->t;
        miss = std::abs(hit->t - desc.reach);
      }
      near = hit->t * 1.0001f + 1e-5f;
    }
    return above + (desc.offset - best) * point.normal;
  }

  struct Met {
    bool something = false, back = false;
    Vec3f radiance{};
    float share = 1;  // transmittance of the passed panes
  };
  Met trace(const Vec3f& origin, const Vec3f& direction, float shell_near) const {
    float near = 0, share = 1;
    for (int pane = 0; pane <= kMaxPanes; ++pane) {
      const std::optional<MeshHit> hit = mesh_.first_hit(origin, direction, near);
      if (!hit) break;
      const Vec3f p = origin + hit->t * direction;
      // Photos show the front; a back side has unknown radiance.
      if (!clear(hit->face, p))
        return {true, hit->from_inside, hit->from_inside ? Vec3f{} : color_at(scene_.mesh, hit->face, p), share};
      near = hit->t * 1.0001f + 1e-5f;
      share *= through_pane(std::abs(dot(hit->normal, direction)));
    }
    if (shell_)
      if (const std::optional<MeshHit> hit = shell_->first_hit(origin, direction, shell_near))
        return {true, false, color_at(scene_.shell, hit->face, origin + hit->t * direction), share};
    // Sky shown by surfels is known too; at that distance only the direction matters.
    const size_t texel = scene_.around.texel_of(direction);
    if (scene_.around.seen(texel) && !scene_.around.wall[texel]) return {true, false, scene_.around.radiance[texel], share};
    return {false, false, {}, share};
  }

 private:
  static float through_pane(float cosine) { return static_cast<float>(1 - kPaneReflectance) * (1 - sheet_grazing(cosine).value); }
  bool clear(uint32_t face, const Vec3f& p) const {
    if (scene_.transmission.empty()) return false;
    const Vec3f w = corner_weights(scene_.mesh, face, p);
    float sum = 0;
    for (size_t c = 0; c < 3; ++c) sum += w[c] * scene_.transmission[scene_.mesh.faces[face][c]];
    return sum > kClear;
  }
  const TransportScene& scene_;
  MeshHits mesh_;
  std::optional<MeshHits> shell_;
};

}  // namespace

Vec3f Transport::irradiance(size_t point, std::span<const Vec3f> light) const {
  const std::span<const float> a = row(point);
  Vec3f sum = known[point];
  for (size_t j = 0; j < a.size(); ++j)
    if (a[j] != 0) sum += a[j] * light[j];
  return sum;
}

Transport transport(const TransportScene& scene, std::span<const LitPoint> points, const TransportDesc& desc,
                    const std::function<void(double)>& progress) {
  const LightGrid& grid = desc.grid;
  const size_t cells = grid.cells();
  const Rays rays(scene);
  Transport out{grid, std::vector<float>(points.size() * cells, 0.f), std::vector<Vec3f>(points.size()),
                std::vector<float>(points.size(), 0.f)};
  const auto shoot = [&](size_t s) {
    const LitPoint& point = points[s];
    const Vec3f origin = point.inner ? rays.start(point, desc) : point.position + desc.outer_offset * point.normal;
    Rng rng(desc.seed, s);
    size_t shot = 0, back = 0;
    for (size_t j = 0; j < cells; ++j) {
      const float u = rng.uniform(), v = rng.uniform();
      const Vec3f direction = grid.direction(j, u, v);
      const float cosine = dot(direction, point.normal);
      if (!(cosine > 0)) continue;
      const Rays::Met met = rays.trace(origin, direction, point.inner ? 0.f : desc.outer_offset);
      const float weight = met.share * cosine * grid.solid_angle();
      ++shot;
      back += met.back;
      if (met.something)
        out.known[s] += weight * met.radiance;
      else
        out.open[s * cells + j] = weight;
    }
    out.inside[s] = shot > 0 ? float(back) / float(shot) : 1.f;
  };
  for (size_t begin = 0; begin < points.size(); begin += kBlock) {
    progress(double(begin) / double(points.size()));
    const size_t count = std::min(kBlock, points.size() - begin);
    parallel_for(count, kChunk, [&](size_t i) { shoot(begin + i); });
  }
  return out;
}

double area_of(const TriMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.faces)
    area += 0.5 * double(length(cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a])));
  return area;
}

TriMesh read_shadow_mesh(const fs::path& folder) {
  const fs::path path = folder / "mesh" / "mesh.ply";
  TriMesh mesh = read_mesh_ply(path);
  const bool extended = area_of(mesh) > 0;
  if (!extended || mesh.colors.size() != mesh.positions.size())
    throw Error(ErrorKind::Input, "the mesh is not usable for shadows",
                {.where = path.string(),
                 .why = mesh.faces.empty() ? "it has no triangles"
                        : !extended        ? "its triangles have no area"
                                           : "it has no colours",
                 .hint = "run the mesh stage again",
                 .code = "NO_SURFACE"});
  return mesh;
}

std::vector<float> transmission_of(const TriMesh& mesh, const std::vector<LitPoint>& points, double voxel) {
  std::vector<Vec3f> positions;
  for (const LitPoint& p : points) positions.push_back(p.position);
  const KdTreef tree(positions);
  std::vector<float> out(mesh.positions.size(), 0.f);
  std::vector<KdTreef::Near> near;
  for (size_t v = 0; v < out.size(); ++v) {
    tree.nearest(mesh.positions[v], 1, float(6 * voxel), near);
    if (!near.empty()) out[v] = points[near[0].index].transmission;
  }
  return out;
}

}  // namespace vitrine
