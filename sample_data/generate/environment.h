// Light from far away: a lat-long map (first row = up = +z, centre = +x, u = 0.75 = -y) with importance sampling.
//   azimuth = -2 pi (u - 1/2),  elevation = pi (1/2 - v),  direction = (cos e cos a, cos e sin a, sin e)
// The texels are rounded to half floats first, so that truth/env/*.exr holds exactly what the pictures were lit by.
#pragma once

#include <functional>
#include <vector>

#include "core/scene/image/image.h"
#include "core/foundation/math/vec.h"

namespace vitrine::generate {

class Environment {
 public:
  Environment() = default;  // black
  explicit Environment(ImageF rgb);

  Vec3f radiance(const Vec3f& direction) const;  // bilinear
  const ImageF& map() const { return map_; }
  bool black() const { return map_.empty(); }

  // Multiplies the sampling weight of each texel: `share`(direction) is the part of the scene that sees it.
  void weigh_sampling(const std::function<float(const Vec3f&)>& share);
  struct Direction {
    Vec3f direction;
    float pdf = 0;  // per steradian
  };
  Direction sample(const Vec2f& u) const;
  float pdf(const Vec3f& direction) const;

 private:
  void build_tables(const std::function<float(const Vec3f&)>& share);
  ImageF map_;
  std::vector<float> row_cdf_, column_cdf_;  // [h + 1], [h * (w + 1)]
  float total_ = 0;
};

// The map of a function, each texel the mean of 3x3 directions, scaled so that an open level white surface has radiosity
// `radiosity` (irradiance / pi = radiosity / pi x pi).
Environment painted_environment(int width, const std::function<Vec3f(const Vec3f&)>& radiance, float radiosity);

// Three skies of our own: noon with broken clouds and a hazy sun, a low red sun, and a dark studio with soft boxes.
Vec3f noon_sky(const Vec3f& direction);
Vec3f sunset_sky(const Vec3f& direction);
Vec3f studio_lights(const Vec3f& direction);

}  // namespace vitrine::generate
