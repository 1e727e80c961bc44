#include "stages/inspect/coverage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/scene/camera/view.h"

namespace vitrine {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kInwardShare = 0.7, kInwardDeg = 30;  // minimum share of cameras that look within this angle of the centre
constexpr double kParallel = 1e-6;                     // minimum spread of the axes; below it they do not intersect
constexpr double kOverheadDeg = 70;                    // photos from higher elevations belong to no ring

double around(double degrees) {
  degrees = std::fmod(degrees, 360.0);
  return degrees < 0 ? degrees + 360 : degrees;
}

}  // namespace

double RingGap::width_deg() const {
  const double w = around(to_deg - from_deg);
  return w == 0 ? 360 : w;  // a single camera
}

Coverage coverage(const ViewSet& set) {
  Coverage out;
  out.cameras = set.views.size();
  if (set.views.empty()) return out;
  const LookedAt meeting = looked_at(set.views);
  out.centre = meeting.point;
  struct Standing {
    double azimuth;
    const View* view;
  };
  std::vector<Standing> ring;
  size_t inward = 0;
  out.lowest_deg = 90, out.highest_deg = -90;
  for (const View& v : set.views) {
    const Vec3d from_centre = v.centre_in_world() - out.centre;
    const double distance = length(from_centre);
    if (!(distance > 0)) continue;
    inward += dot(transposed(v.cam_from_world.rotation).c2, -from_centre / distance) > std::cos(kInwardDeg * kDegree);
    const double elevation = std::asin(std::clamp(from_centre.z / distance, -1.0, 1.0)) / kDegree;
    out.lowest_deg = std::min(out.lowest_deg, elevation);
    out.highest_deg = std::max(out.highest_deg, elevation);
    if (std::abs(elevation) < kOverheadDeg) ring.push_back({around(std::atan2(from_centre.y, from_centre.x) / kDegree), &v});
  }
  out.inward = meeting.spread > kParallel && double(inward) >= kInwardShare * double(set.views.size());
  size_t thin = 0;
  for (const ScenePoint& p : set.points) thin += p.views.size() <= 2;
  if (!set.points.empty()) out.thin_points = double(thin) / double(set.points.size());
  if (!out.inward || ring.empty()) return out;

  std::stable_sort(ring.begin(), ring.end(), [](const Standing& a, const Standing& b) { return a.azimuth < b.azimuth; });
  for (size_t i = 0; i < ring.size(); ++i) {
    const Standing &a = ring[i], &b = ring[(i + 1) % ring.size()];
    if (ring.size() > 1 && i + 1 < ring.size() && b.azimuth == a.azimuth) continue;
    RingGap gap{.from_deg = a.azimuth, .to_deg = b.azimuth, .from = a.view->name, .to = b.view->name};
    if (gap.width_deg() <= 2 * kRingStepDeg) continue;
    gap.photos_to_add = size_t(std::ceil(gap.width_deg() / kRingStepDeg)) - 1;
    out.gaps.push_back(std::move(gap));
  }
  std::stable_sort(out.gaps.begin(), out.gaps.end(),
                   [](const RingGap& a, const RingGap& b) { return a.width_deg() > b.width_deg(); });
  return out;
}

}  // namespace vitrine
