#include "stages/mesh/mesh.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/foundation/base/error.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/camera/view.h"

namespace vitrine {

namespace {

constexpr double kMaxAimAngleDeg = 25;  // median angle between optical axis and the direction to the focus
constexpr double kMinSpread = 0.02;
constexpr size_t kMinPoints = 20;
constexpr double kOutliers = 0.003;  // share of the points cut off on each side of each axis
constexpr double kMostGrowth = 1;    // largest growth per side by unmarked points, relative to the longest side

// Returns false for (nearly) parallel axes.
bool find_focus(const ViewSet& set, Region& region) {
  const LookedAt found = looked_at(set.views);
  if (found.spread < kMinSpread) return false;
  region.focus = found.point;
  std::vector<double> angles, distances;
  for (const View& v : set.views) {
    const Vec3d p = v.cam_from_world * region.focus;
    angles.push_back(std::atan2(std::hypot(p.x, p.y), p.z) * 180 / M_PI);
    distances.push_back(length(p));
  }
  region.camera_distance = upper_median(distances);
  return upper_median(angles) < kMaxAimAngleDeg;
}

// Extends `box` to contain `places` except outliers.
void hold(const std::vector<Vec3d>& places, Bounds3& box) {
  for (size_t axis = 0; axis < 3 && !places.empty(); ++axis) {
    std::vector<double> x;
    for (const Vec3d& p : places) x.push_back(p[axis]);
    const size_t cut = static_cast<size_t>(kOutliers * static_cast<double>(x.size()));
    box.low[axis] = std::min(box.low[axis], order_statistic_of(std::span(x), cut));
    box.high[axis] = std::max(box.high[axis], order_statistic_of(std::span(x), x.size() - 1 - cut));
  }
}

}  // namespace

std::vector<Vec3d> glass_and_gloss(const SplatLayer& diffuse) {
  std::vector<Vec3d> found;
  for (size_t i = 0; i < diffuse.size(); ++i) {
    const float* p = diffuse.at(Attribute::Mean, i);
    const bool shiny = *diffuse.at(Attribute::Transmission, i) > 0 || *diffuse.at(Attribute::SpecularWeight, i) > 0;
    if (shiny && *diffuse.at(Attribute::Opacity, i) > 0) found.push_back({p[0], p[1], p[2]});  // logit: opacity above 1/2
  }
  return found;
}

double Region::extent() const {
  const Vec3d side = box.high - box.low;
  return std::max({side.x, side.y, side.z});
}

Region scene_region(const ViewSet& set, const RegionDesc& desc, std::span<const Vec3d> unmarked) {
  Region region;
  if (set.views.empty())
    throw Error(ErrorKind::Input, "the sfm artifact has no views",
                {.where = "sparse/0", .hint = "compute poses anew: --from sfm --force", .code = "NO_VIEWS"});
  region.convergent = find_focus(set, region);
  if (!desc.box.empty()) {
    const auto& b = desc.box;
    if (b.size() != 6 || !(b[0] < b[3]) || !(b[1] < b[4]) || !(b[2] < b[5]))
      throw Error(ErrorKind::Usage, "mesh.region.box is no box",
                  {.where = "mesh.region.box",
                   .why = "it takes x0 y0 z0 x1 y1 z1 with x0 < x1, y0 < y1, z0 < z1",
                   .hint = "--set mesh.region.box=[-1,-1,-1,1,1,1]",
                   .code = "BAD_BOX"});
    region.box.low = {b[0], b[1], b[2]};
    region.box.high = {b[3], b[4], b[5]};
    return region;
  }
  const double reach = region.convergent ? desc.reach_rel * region.camera_distance : INFINITY;
  std::vector<Vec3d> inside;
  for (const ScenePoint& p : set.points)
    if (length(p.position - region.focus) < reach || !region.convergent) inside.push_back(p.position);
  if (inside.size() < kMinPoints && region.convergent) {  // from the cameras alone: a cube between them
    const double half = reach / std::sqrt(3.0);
    region.box.low = region.focus - Vec3d{half, half, half};
    region.box.high = region.focus + Vec3d{half, half, half};
    return region;
  }
  if (inside.size() < kMinPoints)
    throw Error(ErrorKind::Input, "too few sparse points to find the region of the mesh",
                {.why = fmt::format("{} points, and the cameras do not look at one place", inside.size()),
                 .hint = "give the region: --set mesh.region.box=[x0,y0,z0,x1,y1,z1]",
                 .code = "NO_REGION"});
  region.points = inside.size();
  hold(inside, region.box);
  if (region.convergent) {
    std::vector<Vec3d> near;
    std::ranges::copy_if(unmarked, std::back_inserter(near), [&](const Vec3d& p) { return length(p - region.focus) < reach; });
    // Voxels grow with the region: limits the growth by virtual images behind a flat mirror and by stray surfels.
    Bounds3 grown = region.box;
    if (near.size() >= kMinPoints) hold(near, grown);
    const double most = kMostGrowth * region.extent();
    for (size_t axis = 0; axis < 3; ++axis) {
      region.box.low[axis] = std::max(grown.low[axis], region.box.low[axis] - most);
      region.box.high[axis] = std::min(grown.high[axis], region.box.high[axis] + most);
    }
  }
  const double margin = desc.margin * region.extent();
  region.box.low = region.box.low - Vec3d{margin, margin, margin};
  region.box.high = region.box.high + Vec3d{margin, margin, margin};
  return region;
}

}  // namespace vitrine
