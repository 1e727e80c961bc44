// Light from far away: a lat-long map of linear radiance, looked up bilinearly and sampled in proportion to its luminance.
// Orientation (core/conventions.md, and that of Blender): first row = up = +z, centre = +x, u = 3/4 is -y, so that nothing is
// mirrored for somebody who stands inside:
//   azimuth = -2 pi (u - 1/2),  elevation = pi (1/2 - v),  direction = (cos e cos a, cos e sin a, sin e)
// A texel is drawn with probability  luminance x solid angle  and then a direction evenly over its solid angle, so that
//   pdf(direction) = luminance(texel) / sum of (luminance x solid angle)                  [1/sr]
// where the luminance of a texel is the mean of the bilinear lookup over it.
#pragma once

#include <filesystem>
#include <vector>

#include "core/image/image.h"
#include "core/math/vec.h"

namespace vitrine {

Vec3f lat_long_direction(float u, float v);               // unit
double texel_solid_angle(int y, int width, int height);   // of the texels of row y, steradians
Vec2f lat_long_coordinates(const Vec3f& unit_direction);  // u in [0, 1), v in [0, 1]

class Environment {
 public:
  Environment() = default;  // black
  // `rgb`: [h, 2h, 3], finite and not negative.
  explicit Environment(ImageF rgb, const Mat3f& world_from_map = Mat3f::identity());

  const ImageF& map() const { return map_; }  // as it was given: not rotated
  const Mat3f& world_from_map() const { return world_from_map_; }
  bool black() const { return !(total_ > 0); }

  Vec3f radiance(const Vec3f& unit_direction) const;

  struct Sample {
    Vec3f direction{};  // unit
    Vec3f radiance{};
    float pdf = 0;  // per steradian; 0: the environment is black
  };
  Sample sample(const Vec2f& uniform) const;  // two numbers in [0, 1)
  float pdf(const Vec3f& unit_direction) const;
  // Of a surface with that normal which nothing shades: the integral of radiance x cosine, by texels.
  Vec3f irradiance(const Vec3f& unit_normal) const;
  // Mean radiance over the sphere.
  Vec3f mean() const { return mean_; }

  // The same light turned about +z, counter-clockwise seen from above: what shone from +x shines from +y at 90. Turning by 360
  // changes no bit.
  Environment rotated(double degrees) const;
  Environment turned(const Mat3f& rotation) const;

 private:
  ImageF map_;
  Mat3f world_from_map_ = Mat3f::identity();
  std::vector<float> density_;              // [h, w] luminance that is sampled, mean of the lookup over the texel
  std::vector<float> row_cdf_, texel_cdf_;  // [h + 1], [h, w + 1]; from 0 to 1
  double total_ = 0;                        // sum of density x solid angle
  Vec3f mean_{};
};

// OpenEXR or Radiance HDR, told apart by their first bytes. Throws Error{Input} for what cannot light a scene: an 8-bit picture
// (ENV_LDR), texels that are NaN or infinite (ENV_BAD_TEXELS), another shape than 2:1 (ENV_SHAPE), unknown or damaged files.
// An EXR of other primaries (chromaticities) is converted. Channels below zero, which resampling and colours outside Rec.709
// leave, become zero; `negative`: how many texels had some.
Environment read_environment(const std::filesystem::path& path, size_t* negative = nullptr);
// As 32-bit EXR that says its orientation in the attribute "vitrine:lat_long". Only maps that are not turned.
void write_environment(const std::filesystem::path& path, const Environment& environment);

// Six patches on the axes, for looking at orientations: +x red, -x cyan, +y green, -y magenta, +z blue, -z yellow; grey between.
Environment axis_probe(int width);

}  // namespace vitrine
