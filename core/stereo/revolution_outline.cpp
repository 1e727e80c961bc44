#include <algorithm>
#include <cmath>

#include "core/stereo/revolution_fit.h"

namespace vitrine {

namespace {

// Whether origin + t direction, t > 0, enters the solid between two of its radii. There both the way from the axis and the radius
// are linear in t, and a ray that is inside at all is so at an end or where distance^2 - radius^2 is least.
bool meets_slab(const SolidOfRevolution& solid, size_t i, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d from = origin - solid.origin;
  const double h = dot(from, solid.axis), climb = dot(direction, solid.axis);
  const double low = solid.low + solid.step * double(i), high = low + solid.step;
  double t0 = 0, t1 = 1e9;
  if (std::abs(climb) < 1e-12) {
    if (h < low || h > high) return false;
  } else {
    const double a = (low - h) / climb, b = (high - h) / climb;
    t0 = std::max(t0, std::min(a, b)), t1 = std::min(t1, std::max(a, b));
  }
  if (!(t0 < t1)) return false;
  const Vec3d across = from - h * solid.axis, move = direction - climb * solid.axis;
  const double widen = (solid.radii[i + 1] - solid.radii[i]) / solid.step;
  const double radius = solid.radii[i] + widen * (h - low), growth = widen * climb;
  const double a = dot(move, move) - growth * growth, b = dot(across, move) - radius * growth;
  const double c = dot(across, across) - radius * radius;
  const auto inside = [&](double t) { return c + t * (2 * b + t * a) <= 0; };
  return inside(t0) || inside(t1) || (a > 0 && -b / a > t0 && -b / a < t1 && inside(-b / a));
}

}  // namespace

std::vector<uint8_t> outline_mask(const SolidOfRevolution& solid, const View& view) {
  return mask_of_rays(view, [&](size_t, const Vec3d& eye, const Vec3d& direction) {
    for (size_t i = 0; i + 1 < solid.radii.size(); ++i)
      if (meets_slab(solid, i, eye, direction)) return true;
    return false;
  });
}

}  // namespace vitrine
