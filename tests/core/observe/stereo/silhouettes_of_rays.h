// Cameras around the origin, and the silhouettes that they see of a thing that a ray meets or misses.
#pragma once

#include <cmath>
#include <numbers>
#include <vector>

#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// From `count` places within `span_rad` of azimuth; meets(eye, unit direction).
template <class Meets>
std::vector<Silhouette> silhouettes_of_rays(int count, double span_rad, const Meets& meets) {
  std::vector<Silhouette> masks;
  for (int i = 0; i < count; ++i) {
    const double azimuth = span_rad * i / count, elevation = i % 3 == 0 ? 0.9 : i % 3 == 1 ? 0.35 : -0.3;
    const Vec3d eye{std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation), std::sin(elevation)};
    const Vec3d forward = normalized(-eye), right = normalized(cross(forward, Vec3d{0, 0, 1}));
    Silhouette m;
    m.view.intrinsics = {96, 80, 90, 90, 48, 40};
    m.view.cam_from_world = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, eye});
    m.value = ImageF(96, 80, 1);
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 96; ++x) {
        const Vec3d ray = m.view.ray(x + 0.5, y + 0.5);
        m.value.at(x, y) = meets(eye, normalized(ray)) ? 1.f : 0.f;
      }
    masks.push_back(std::move(m));
  }
  return masks;
}

inline bool meets_ball(const Vec3d& centre, double radius, const Vec3d& eye, const Vec3d& d) {
  const Vec3d to = centre - eye;
  return length(to - dot(to, d) * d) < radius;
}

// A box around the origin, turned by `turn` about z.
inline bool meets_box(const Vec3d& half, double turn, const Vec3d& eye, const Vec3d& ray) {
  const double c = std::cos(turn), s = std::sin(turn);
  const Vec3d o{c * eye.x + s * eye.y, -s * eye.x + c * eye.y, eye.z}, d{c * ray.x + s * ray.y, -s * ray.x + c * ray.y, ray.z};
  double near = -1e9, far = 1e9;
  for (size_t i = 0; i < 3; ++i) {
    const double a = (-half[i] - o[i]) / d[i], b = (half[i] - o[i]) / d[i];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near < far && near > 0;
}

// An upright cylinder around the origin.
inline bool meets_cylinder(double radius, double half_height, const Vec3d& eye, const Vec3d& d) {
  double near = -1e9, far = 1e9;
  const double a = (-half_height - eye.z) / d.z, b = (half_height - eye.z) / d.z;
  near = std::min(a, b), far = std::max(a, b);
  const double qa = d.x * d.x + d.y * d.y, qb = eye.x * d.x + eye.y * d.y, qc = eye.x * eye.x + eye.y * eye.y - radius * radius;
  const double root = qb * qb - qa * qc;
  if (root < 0) return false;
  near = std::max(near, (-qb - std::sqrt(root)) / qa), far = std::min(far, (-qb + std::sqrt(root)) / qa);
  return near < far && near > 0;
}

}  // namespace vitrine
