#include "stages/inspect/coverage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vitrine {

namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kInwardShare = 0.7, kInwardDeg = 30;  // so many cameras look so close to the centre
constexpr double kOverheadDeg = 70;                    // photos from above stand in no ring

double around(double degrees) {
  degrees = std::fmod(degrees, 360.0);
  return degrees < 0 ? degrees + 360 : degrees;
}

// argmin_p sum |(I - d d^T) (p - c)|^2. When all axes are parallel there is none: the mean camera centre.
Vec3d nearest_to_axes(const std::vector<View>& views) {
  Mat3d m{};
  Vec3d right{}, mean{};
  for (const View& v : views) {
    const Vec3d d = transposed(v.cam_from_world.rotation).c2, c = v.centre_in_world();
    m.c0 += Vec3d{1, 0, 0} - d.x * d;
    m.c1 += Vec3d{0, 1, 0} - d.y * d;
    m.c2 += Vec3d{0, 0, 1} - d.z * d;
    right += c - dot(d, c) * d;
    mean += c / double(views.size());
  }
  const double n = double(views.size()), det = determinant(m);
  constexpr double kParallel = 1e-6;
  if (det < kParallel * n * n * n) return mean;
  return {determinant(Mat3d{right, m.c1, m.c2}) / det, determinant(Mat3d{m.c0, right, m.c2}) / det,
          determinant(Mat3d{m.c0, m.c1, right}) / det};
}

}  // namespace

double RingGap::width_deg() const {
  const double w = around(to_deg - from_deg);
  return w == 0 ? 360 : w;  // one camera only
}

Coverage coverage(const ViewSet& set) {
  Coverage out;
  out.cameras = set.views.size();
  if (set.views.empty()) return out;
  out.centre = nearest_to_axes(set.views);
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
  out.inward = double(inward) >= kInwardShare * double(set.views.size());
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
