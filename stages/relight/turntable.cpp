#include "stages/relight/relight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/math/median.h"
#include "core/scene/camera/view.h"

namespace vitrine {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kWidestGap = kPi / 3;  // a ring with smaller gaps counts as closed

// Upright camera at `centre` that looks at `target`.
Rigid looking_at(const Vec3d& centre, const Vec3d& target) {
  const Vec3d forward = normalized(target - centre);
  const Vec3d across = cross(forward, Vec3d{0, 0, 1});
  const Vec3d right = length(across) > 1e-9 ? normalized(across) : Vec3d{1, 0, 0};
  return inverse(Rigid{Mat3d{right, cross(forward, right), forward}, centre});
}

// The arc that the photos cover: start and counter-clockwise extent.
struct Arc {
  double begin = 0, length = 2 * kPi;
  bool closed() const { return length > 2 * kPi - kWidestGap; }
};
Arc covered(std::vector<double> azimuths) {
  std::ranges::sort(azimuths);
  double widest = azimuths.front() + 2 * kPi - azimuths.back();
  size_t after = 0;
  for (size_t i = 1; i < azimuths.size(); ++i)
    if (azimuths[i] - azimuths[i - 1] > widest) widest = azimuths[i] - azimuths[i - 1], after = i;
  return {azimuths[after], 2 * kPi - widest};
}

}  // namespace

Vec3d point_looked_at(std::span<const View> views) {
  constexpr double kParallel = 1e-9;
  const LookedAt found = looked_at(views);
  // Parallel axes do not intersect: use one unit in front of the first camera.
  if (found.spread < kParallel)
    return views[0].centre_in_world() + transposed_times(views[0].cam_from_world.rotation, Vec3d{0, 0, 1});
  return found.point;
}

std::vector<View> turntable_views(std::span<const View> photos, int frames) {
  VITRINE_CHECK(!photos.empty() && frames > 0, "a turntable of {} photos and {} frames", photos.size(), frames);
  const Vec3d target = point_looked_at(photos);
  std::vector<double> radii, heights, azimuths;
  for (const View& v : photos) {
    const Vec3d offset = v.centre_in_world() - target;
    radii.push_back(std::hypot(offset.x, offset.y));
    heights.push_back(offset.z);
    azimuths.push_back(std::atan2(offset.y, offset.x));
  }
  const double radius = upper_median(radii), height = upper_median(heights);
  const Arc arc = covered(azimuths);
  std::vector<View> views;
  for (int i = 0; i < frames; ++i) {
    const double turn = double(i) / frames;
    const double azimuth = arc.begin + (arc.closed() ? 2 * kPi * turn : arc.length * 0.5 * (1 - std::cos(2 * kPi * turn)));
    View v;
    v.name = fmt::format("frame_{:04}.png", i);
    v.intrinsics = photos[0].intrinsics;
    v.cam_from_world = looking_at(target + Vec3d{radius * std::cos(azimuth), radius * std::sin(azimuth), height}, target);
    views.push_back(v);
  }
  return views;
}

}  // namespace vitrine
