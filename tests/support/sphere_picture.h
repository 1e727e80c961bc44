// Pictures of a textured sphere seen from its centre: panoramas and pinhole photos of the same surroundings.
#pragma once

#include <array>
#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/scene/camera/equirect.h"
#include "core/scene/camera/view.h"

namespace vitrine::test {

// Sum of plane waves at a direction: smooth, 0.1 to 0.9, details of 10 degrees and more.
class SphereTexture {
 public:
  explicit SphereTexture(uint64_t seed) {
    Rng rng(seed);
    for (Wave& w : waves_) {
      for (size_t c = 0; c < 3; ++c) w.vector[c] = 40.0 * double(rng.uniform()) - 20;
      w.phase = 6.28 * double(rng.uniform());
    }
  }
  float at(const Vec3d& direction) const {
    const Vec3d d = normalized(direction);
    double sum = 0;
    for (const Wave& w : waves_) sum += std::cos(dot(w.vector, d) + w.phase);
    return float(0.5 + 0.4 * std::tanh(sum / 4));
  }

 private:
  struct Wave {
    Vec3d vector;
    double phase = 0;
  };
  std::array<Wave, 24> waves_;
};

template <class F>
ImageF picture_of(int width, int height, F&& direction, uint64_t seed = 1) {
  const SphereTexture texture(seed);
  ImageF out(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float v = texture.at(direction(x + 0.5, y + 0.5));
      for (int c = 0; c < 3; ++c) out.at(x, y, c) = v * (1 - 0.1f * float(c));
    }
  return out;
}

inline ImageF sphere_panorama(int width, uint64_t seed = 1) {
  return picture_of(
      width, width / 2, [&](double x, double y) { return equirect_direction(x, y, width, width / 2); }, seed);
}

inline ImageF sphere_photo(const Intrinsics& k, const Mat3d& view_from_panorama = Mat3d::identity(), uint64_t seed = 1) {
  return picture_of(
      k.width, k.height, [&](double x, double y) { return transposed_times(view_from_panorama, k.ray(x, y)); }, seed);
}

}  // namespace vitrine::test
