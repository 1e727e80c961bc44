// Sets of 3D Gaussians and rays for the tests of core/render/volume.
#pragma once

#include <numbers>
#include <vector>

#include "core/foundation/base/rng.h"
#include "core/render/volume/gaussian3.h"
#include "core/render/volume/volume_ray.h"

namespace vitrine::test {

// Anisotropic, in the unit ball around `centre`; quaternions are not unit.
inline std::vector<Gaussian3d> random_gaussians(size_t count, const Vec3d& centre, uint64_t seed) {
  std::vector<Gaussian3d> out(count);
  for (size_t i = 0; i < count; ++i) {
    Rng rng(seed, i);
    const auto normal = [&] { return double(rng.normal()); };
    Gaussian3d& g = out[i];
    g.mean = centre + 0.4 * Vec3d{normal(), normal(), normal()};
    g.log_scale = Vec3d{-2.2, -2.2, -2.2} + 0.5 * Vec3d{normal(), normal(), normal()};
    g.rotation = {1.3 * normal(), normal(), normal(), normal()};
    g.log_density = 0.5 * normal();
  }
  // Stored as float in the fast path: equal inputs.
  for (Gaussian3d& g : out) g = cast<double>(cast<float>(g));
  return out;
}

// Cone beam from `distance` before the centre through a picture of w x h at the centre, 2.4 wide.
inline std::vector<VolumeRay> cone_rays(int w, int h, const Vec3d& centre, double distance, double turn) {
  std::vector<VolumeRay> rays;
  const Vec3d away{std::cos(turn), std::sin(turn), 0}, across{-std::sin(turn), std::cos(turn), 0};
  const Vec3d source = centre + distance * away;
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      const double u = ((x + 0.5) / w - 0.5) * 2.4, v = (0.5 * h - y - 0.5) / w * 2.4;
      rays.push_back({source, normalized(centre + u * across + Vec3d{0, 0, v} - source)});
    }
  return rays;
}

inline std::vector<Gaussian3f> floats(const std::vector<Gaussian3d>& set) {
  std::vector<Gaussian3f> out;
  for (const Gaussian3d& g : set) out.push_back(cast<float>(g));
  return out;
}
inline std::vector<double> flat(const std::vector<Gaussian3d>& set) {
  std::vector<double> out;
  for (const Gaussian3d& g : set)
    for (const double v : values_of(g)) out.push_back(v);
  return out;
}
inline std::vector<double> flat(const std::vector<Gaussian3Gradient>& set) {
  std::vector<double> out;
  for (const Gaussian3Gradient& g : set)
    for (const float v : g) out.push_back(double(v));
  return out;
}

}  // namespace vitrine::test
