#include <algorithm>
#include <cmath>

#include "core/stereo/revolution_fit.h"

namespace vitrine {

namespace {

// The first t > 0 at which origin + t direction is inside the solid between two of its radii. There both the way from the axis
// and the radius are linear in t: a ray is inside where a quadratic is not positive.
std::optional<double> enters_slab(const SolidOfRevolution& solid, size_t i, const Vec3d& origin, const Vec3d& direction) {
  const Vec3d from = origin - solid.origin;
  const double h = dot(from, solid.axis), climb = dot(direction, solid.axis);
  const double low = solid.low + solid.step * double(i), high = low + solid.step;
  double t0 = 0, t1 = 1e9;
  if (std::abs(climb) < 1e-12) {
    if (h < low || h > high) return std::nullopt;
  } else {
    const double a = (low - h) / climb, b = (high - h) / climb;
    t0 = std::max(t0, std::min(a, b)), t1 = std::min(t1, std::max(a, b));
  }
  if (!(t0 < t1)) return std::nullopt;
  const Vec3d across = from - h * solid.axis, move = direction - climb * solid.axis;
  const double widen = (solid.radii[i + 1] - solid.radii[i]) / solid.step;
  const double radius = solid.radii[i] + widen * (h - low), growth = widen * climb;
  const double a = dot(move, move) - growth * growth, b = dot(across, move) - radius * growth;
  const double c = dot(across, across) - radius * radius;  // c + 2 b t + a t^2 <= 0
  if (c + t0 * (2 * b + t0 * a) <= 0) return t0;
  const double discriminant = b * b - a * c;
  if (discriminant < 0) return std::nullopt;
  // Outside at t0: inside from the first root beyond it at which the quadratic falls. q / a and c / q, without cancellation.
  const double q = -(b + std::copysign(std::sqrt(discriminant), b));
  double enters = 1e300;
  for (const double root : {a != 0 ? q / a : 1e300, q != 0 ? c / q : 1e300})
    if (root > t0 && root < t1) enters = std::min(enters, root);
  if (enters < t1) return enters;
  return std::nullopt;
}

}  // namespace

std::optional<double> SolidOfRevolution::entry(const Vec3d& eye, const Vec3d& direction) const {
  std::optional<double> first;
  for (size_t i = 0; i + 1 < radii.size(); ++i)
    if (const auto t = enters_slab(*this, i, eye, direction); t && (!first || *t < *first)) first = t;
  return first;
}

SurfaceOfRevolution surface_of_revolution(const SolidOfRevolution& solid) {
  SurfaceOfRevolution out{solid.origin, solid.axis, {{0, solid.low}}};
  for (size_t i = 0; i < solid.radii.size(); ++i) out.profile.push_back({solid.radii[i], solid.low + solid.step * double(i)});
  out.profile.push_back({0, solid.top()});
  return out;
}

std::vector<uint8_t> silhouette_mask(const SolidOfRevolution& solid, const View& view) {
  return mask_of_rays(view,
                      [&](size_t, const Vec3d& eye, const Vec3d& direction) { return solid.entry(eye, direction).has_value(); });
}

}  // namespace vitrine
