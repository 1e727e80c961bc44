#include "stages/evaluate/mesh_error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/mesh/mesh_distance.h"
#include "stages/evaluate/view_error.h"

namespace vitrine {

namespace {

constexpr size_t kSamplesPerTask = 4096;

Vec3d to_double(const Vec3f& p) { return {p.x, p.y, p.z}; }

bool in_mask(const ImageF& mask, const ImagePoint& p) { return !mask.empty() && mask.at(int(p.x), int(p.y)) > 0; }

struct Distances {
  double mean_rel = 0, median_rel = 0, within = 0;
};
Distances distances_to(const MeshDistance& target, const std::vector<Vec3f>& points, double diagonal, double threshold_rel) {
  std::vector<double> rel;
  for (float d : target.distances(points)) rel.push_back(d / diagonal);
  const auto near = std::count_if(rel.begin(), rel.end(), [&](double d) { return d <= threshold_rel; });
  return {mean(rel), median(rel), double(near) / double(rel.size())};
}

constexpr double kNear_rel = 1e-4;  // near plane, relative to the distance of the mesh's farthest vertex

struct ScreenVertex {
  double x, y, inverse_z;
};

void fill_triangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, ImageF& zdepth) {
  const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (!(std::abs(area) > 1e-12)) return;
  const auto first = [](double low, int limit) { return int(std::clamp(std::ceil(low - 0.5), 0.0, double(limit))); };
  const auto last = [](double high, int limit) { return int(std::clamp(std::floor(high - 0.5), -1.0, double(limit - 1))); };
  const int x0 = first(std::min({a.x, b.x, c.x}), zdepth.width()), x1 = last(std::max({a.x, b.x, c.x}), zdepth.width());
  const int y0 = first(std::min({a.y, b.y, c.y}), zdepth.height()), y1 = last(std::max({a.y, b.y, c.y}), zdepth.height());
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double px = x + 0.5, py = y + 0.5;
      const double wb = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area;
      const double wc = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area;
      const double wa = 1 - wb - wc;
      if (wa < 0 || wb < 0 || wc < 0) continue;
      const float z = float(1 / (wa * a.inverse_z + wb * b.inverse_z + wc * c.inverse_z));
      float& old = zdepth.at(x, y);
      if (old == 0 || z < old) old = z;
    }
}

}  // namespace

TriMesh transformed(const TriMesh& mesh, const Similarity& new_from_old) {
  TriMesh out;
  out.faces = mesh.faces;
  for (const Vec3f& p : mesh.positions) {
    const Vec3d q = new_from_old * to_double(p);
    out.positions.push_back({float(q.x), float(q.y), float(q.z)});
  }
  return out;
}

MeshError mesh_error(const TriMesh& ours, const TriMesh& truth, const TriMesh& first_surface, size_t view_count,
                     const std::function<MeshView(size_t)>& view, const MeshErrorDesc& desc) {
  Bounds3 bounds;
  for (const Vec3f& p : truth.positions) bounds.extend(to_double(p));
  MeshError result;
  result.diagonal = bounds.diagonal();
  const SurfaceSamples our_samples = sample_surface(ours, desc.samples, desc.seed);
  const SurfaceSamples truth_samples = sample_surface(truth, desc.samples, desc.seed);
  if (!(result.diagonal > 0) || truth_samples.positions.empty())
    throw Error(ErrorKind::Input, "the truth mesh has no surface",
                {.why = "its triangles have no area", .hint = "mend the file, or --truth none", .code = "TRUTH_BAD_MESH"});

  struct Votes {
    uint16_t seen = 0, on_truth = 0;
  };
  std::vector<Votes> ours_votes(our_samples.positions.size());
  std::vector<uint16_t> truth_seen(truth_samples.positions.size());
  for (size_t v = 0; v < view_count; ++v) {
    const MeshView mv = view(v);
    const ImageF our_zdepth = mesh_zdepth(ours, mv.intrinsics, mv.cam_from_world);
    const ImageF truth_mesh_zdepth = mesh_zdepth(truth, mv.intrinsics, mv.cam_from_world);
    const ImageF first_zdepth = mv.zdepth.empty() ? mesh_zdepth(first_surface, mv.intrinsics, mv.cam_from_world) : mv.zdepth;
    parallel_for(ours_votes.size(), kSamplesPerTask, [&](size_t i) {
      const auto p = image_point(mv.cam_from_world * to_double(our_samples.positions[i]), mv.intrinsics);
      if (!p || !agrees_with(our_zdepth, *p, desc.depth_tolerance_rel)) return;
      ++ours_votes[i].seen;
      const double z_mesh = truth_mesh_zdepth.at(int(p->x), int(p->y)), z_first = first_zdepth.at(int(p->x), int(p->y));
      if (z_mesh > 0 && std::abs(z_mesh - z_first) <= desc.depth_tolerance_rel * z_mesh && !in_mask(mv.transparent, *p))
        ++ours_votes[i].on_truth;
    });
    parallel_for(truth_seen.size(), kSamplesPerTask, [&](size_t i) {
      const auto p = image_point(mv.cam_from_world * to_double(truth_samples.positions[i]), mv.intrinsics);
      if (p && !in_mask(mv.transparent, *p) && agrees_with(first_zdepth, *p, desc.depth_tolerance_rel)) ++truth_seen[i];
    });
  }

  std::vector<Vec3f> our_points, truth_points;
  for (size_t i = 0; i < ours_votes.size(); ++i)
    if (ours_votes[i].on_truth >= desc.min_views && 2 * ours_votes[i].on_truth > ours_votes[i].seen)
      our_points.push_back(our_samples.positions[i]);
  for (size_t i = 0; i < truth_seen.size(); ++i)
    if (truth_seen[i] >= desc.min_views) truth_points.push_back(truth_samples.positions[i]);
  result.our_samples = our_points.size();
  result.truth_samples = truth_points.size();

  const Distances accuracy = distances_to(MeshDistance(truth), our_points, result.diagonal, desc.threshold_rel);
  const Distances completeness = distances_to(MeshDistance(ours), truth_points, result.diagonal, desc.threshold_rel);
  result.accuracy_rel = accuracy.mean_rel;
  result.accuracy_median_rel = accuracy.median_rel;
  result.completeness_rel = completeness.mean_rel;
  result.completeness_median_rel = completeness.median_rel;
  result.chamfer_rel = 0.5 * (accuracy.mean_rel + completeness.mean_rel);
  result.precision = our_points.empty() ? 0 : accuracy.within;
  result.recall = truth_points.empty() ? 0 : completeness.within;
  const double sum = result.precision + result.recall;
  result.fscore = sum > 0 ? 2 * result.precision * result.recall / sum : 0;
  return result;
}

ImageF mesh_zdepth(const TriMesh& mesh, const Intrinsics& k, const Rigid& cam_from_world) {
  ImageF zdepth(k.width, k.height, 1);
  std::vector<Vec3d> in_cam(mesh.positions.size());
  double farthest = 0;
  for (size_t i = 0; i < in_cam.size(); ++i) {
    const Vec3f& p = mesh.positions[i];
    in_cam[i] = cam_from_world * Vec3d{p.x, p.y, p.z};
    farthest = std::max(farthest, in_cam[i].z);
  }
  const double near_z = kNear_rel * farthest;
  const auto on_screen = [&](const Vec3d& in_camera) {
    const ImagePoint p = projected(in_camera, k);
    return ScreenVertex{p.x, p.y, 1 / p.z};
  };
  for (const auto& face : mesh.faces) {
    const std::array<Vec3d, 3> v{in_cam[face[0]], in_cam[face[1]], in_cam[face[2]]};
    if (v[0].z <= near_z && v[1].z <= near_z && v[2].z <= near_z) continue;
    std::array<Vec3d, 4> polygon;  // a triangle clipped by one plane has at most four corners
    size_t corners = 0;
    for (size_t i = 0; i < 3; ++i) {
      const Vec3d &p = v[i], &q = v[(i + 1) % 3];
      if (p.z > near_z) polygon[corners++] = p;
      if ((p.z > near_z) != (q.z > near_z)) {
        Vec3d cut = p + ((near_z - p.z) / (q.z - p.z)) * (q - p);
        cut.z = near_z;
        polygon[corners++] = cut;
      }
    }
    for (size_t i = 2; i < corners; ++i)
      fill_triangle(on_screen(polygon[0]), on_screen(polygon[i - 1]), on_screen(polygon[i]), zdepth);
  }
  return zdepth;
}

bool agrees_with(const ImageF& zdepth, const ImagePoint& p, double tolerance_rel) {
  const int x0 = int(std::floor(p.x - 0.5)), y0 = int(std::floor(p.y - 0.5));
  for (int y = std::max(y0, 0); y <= std::min(y0 + 1, zdepth.height() - 1); ++y)
    for (int x = std::max(x0, 0); x <= std::min(x0 + 1, zdepth.width() - 1); ++x) {
      const double z = zdepth.at(x, y);
      if (z > 0 && std::abs(p.z - z) <= tolerance_rel * z) return true;
    }
  return false;
}

}  // namespace vitrine
