#include "stages/mesh/watertight.h"

#include <algorithm>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/mesh/mesh_distance.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/mesh/repair_cgal.h"

namespace vitrine {

namespace {

constexpr uint64_t kPointSeed = 0x5ea1;
constexpr size_t kMeasuredPoints = 20000;
constexpr int kRepairRounds = 4;
constexpr size_t kAnyHole = size_t(1) << 20;  // of the repair: the surface was closed, so every hole is the repair's own

bool is_valid(const TriMesh& mesh) {
  const MeshReport r = mesh_report(mesh);
  return r.closed() && r.degenerate_faces == 0;
}

// Without faces that cut each other, if that leaves the surface closed.
TriMesh without_crossings(TriMesh mesh) {
  TriMesh tried = mesh;
  for (int round = 0; round < kRepairRounds; ++round) {
    if (round > 0 && is_valid(tried) && self_intersection_count(tried) == 0) return tried;
    tried.normals = vertex_normals(tried);  // keeps the orientation
    tried = repaired(tried, {.max_hole_edges = kAnyHole, .intersection_rounds = 3});
  }
  return is_valid(tried) && self_intersection_count(tried) == 0 ? tried : mesh;
}

Vec3f color_at(const TriMesh& mesh, const ClosestPoint& at) {
  const auto& [i, j, k] = mesh.faces[at.face];
  const Vec3f &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k], &p = at.position;
  const float u = length(cross(b - p, c - p)), v = length(cross(c - p, a - p)), w = length(cross(a - p, b - p));
  const float sum = u + v + w;
  if (!(sum > 0)) return mesh.colors[i];
  return (u / sum) * mesh.colors[i] + (v / sum) * mesh.colors[j] + (w / sum) * mesh.colors[k];
}

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (float v : values) sum += v;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

void measure(const TriMesh& closed, const TriMesh& fused, const MeshDistance& to_fused, double voxel, WatertightReport& report) {
  const std::vector<float> away = to_fused.distances(sample_surface(closed, kMeasuredPoints, kPointSeed).positions);
  report.to_fused = mean(away);
  report.from_fused = mean(MeshDistance(closed).distances(sample_surface(fused, kMeasuredPoints, kPointSeed).positions));
  const auto far = std::count_if(away.begin(), away.end(), [&](float d) { return d > kInventedVoxels * voxel; });
  report.invented_share = away.empty() ? 0 : static_cast<double>(far) / static_cast<double>(away.size());
}

}  // namespace

TriMesh watertight(const TriMesh& fused, const WatertightDesc& desc, const std::function<void(double)>& progress,
                   WatertightReport& report) {
  report = {};
  report.fused = mesh_report(fused);
  const double wanted = report.fused.area / (desc.voxel * desc.voxel);
  const SurfaceSamples samples =
      sample_surface(fused, static_cast<size_t>(std::min(wanted, 0.5 * static_cast<double>(desc.faces))), kPointSeed);
  TriMesh mesh =
      poisson_surface(samples.positions, samples.normals, &report.poisson, [&](double f) { progress(0.6 * std::min(f, 1.0)); });
  progress(0.6);
  mesh = without_small_components(mesh, desc.pieces);
  const auto keep_if_valid = [&](TriMesh next) {
    if (is_valid(next)) mesh = std::move(next);
  };
  TriMesh smooth = mesh;
  taubin_smooth(smooth, {.iterations = desc.smooth_iterations});
  keep_if_valid(std::move(smooth));
  progress(0.7);
  if (mesh.faces.size() > desc.faces) keep_if_valid(decimated(mesh, {.target_faces = desc.faces}));
  progress(0.9);
  mesh = without_crossings(std::move(mesh));
  if (!is_valid(mesh))
    throw Error(ErrorKind::Input, "the Poisson surface is not closed after cleaning",
                {.why = "it has too few faces, or faces without an area",
                 .hint = "a higher mesh.faces or mesh.resolution; mesh.method fusion needs no closed surface",
                 .code = "NOT_CLOSED"});
  mesh.normals = vertex_normals(mesh);
  const MeshDistance to_fused(fused);
  if (!fused.colors.empty()) {
    mesh.colors.resize(mesh.positions.size());
    parallel_for(mesh.positions.size(), 1024,
                 [&](size_t v) { mesh.colors[v] = color_at(fused, to_fused.closest(mesh.positions[v])); });
  }
  measure(mesh, fused, to_fused, desc.voxel, report);
  progress(1);
  return mesh;
}

int64_t genus_of(const MeshReport& mesh) {
  return (2 * static_cast<int64_t>(mesh.components) - static_cast<int64_t>(mesh.boundary_loops) - mesh.euler) / 2;
}

}  // namespace vitrine
