// Environment map: distant light as a lat-long map of linear radiance, bilinear lookup, importance sampling by luminance.
// Orientation (core/conventions.md, same as Blender): first row = +z (up), centre = +x, u = 3/4 is -y. Seen from inside, the map
// is not mirrored:
//   azimuth = -2 pi (u - 1/2),  elevation = pi (1/2 - v),  direction = (cos e cos a, cos e sin a, sin e)
// A texel is sampled with probability proportional to luminance x solid angle, then a direction uniformly over its solid angle:
//   pdf(direction) = luminance(texel) / sum of (luminance x solid angle)                  [1/sr]
// The luminance of a texel is the mean of the bilinear lookup over it.
#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/math/vec.h"
#include "core/scene/image/image.h"

namespace vitrine {

Vec3f lat_long_direction(float u, float v);               // unit
double texel_solid_angle(int y, int width, int height);   // of a texel in row y, steradians
Vec2f lat_long_coordinates(const Vec3f& unit_direction);  // u in [0, 1), v in [0, 1]

class Environment {
 public:
  Environment() = default;  // black
  // `rgb`: [h, 2h, 3], finite, non-negative.
  explicit Environment(ImageF rgb, const Mat3f& world_from_map = Mat3f::identity());

  const ImageF& map() const { return map_; }  // as given, without rotation
  const Mat3f& world_from_map() const { return world_from_map_; }
  bool black() const { return !(total_ > 0); }

  Vec3f radiance(const Vec3f& unit_direction) const;

  struct Sample {
    Vec3f direction{};  // unit
    Vec3f radiance{};
    float pdf = 0;  // per steradian; 0 if the environment is black
  };
  Sample sample(const Vec2f& uniform) const;  // `uniform`: two numbers in [0, 1)
  float pdf(const Vec3f& unit_direction) const;
  // Irradiance of an unoccluded surface with this normal: radiance x cosine, summed over texels.
  Vec3f irradiance(const Vec3f& unit_normal) const;
  // Mean radiance over the sphere.
  Vec3f mean() const { return mean_; }

  // Rotates the environment about +z, counter-clockwise seen from above: at 90 degrees the light from +x comes from +y. 360
  // degrees gives identical bits.
  Environment rotated(double degrees) const;
  Environment turned(const Mat3f& rotation) const;

 private:
  ImageF map_;
  Mat3f world_from_map_ = Mat3f::identity();
  std::vector<float> density_;              // [h, w] sampled luminance: mean of the lookup over the texel
  std::vector<float> row_cdf_, texel_cdf_;  // [h + 1], [h, w + 1]; from 0 to 1
  double total_ = 0;                        // sum of density x solid angle
  Vec3f mean_{};
};

// Reads OpenEXR, Radiance HDR or TIFF, detected by the first bytes. Throws Error{Input} for 8-bit images (ENV_LDR), NaN or
// infinite texels (ENV_BAD_TEXELS), aspect ratios other than 2:1 (ENV_SHAPE), unknown or damaged files. EXR files with other
// primaries (chromaticities) are converted. Negative channels (from resampling, or colours outside Rec. 709) are set to 0;
// `negative` receives the number of such texels.
Environment read_environment(const std::filesystem::path& path, size_t* negative = nullptr);
// Writes 32-bit EXR; the attribute "vitrine:lat_long" stores the orientation. Unrotated maps only.
void write_environment(const std::filesystem::path& path, const Environment& environment);

// Test map with six patches on the axes: +x red, -x cyan, +y green, -y magenta, +z blue, -z yellow; grey elsewhere.
Environment axis_probe(int width);

// Octahedral map of directions (Engelhardt and Dachsbacher 2008), +z at the centre: (x, y) in [-1, 1]^2 maps to the direction (x,
// y, 1 - |x| - |y|), folded outwards where z is below 0, normalised.
inline Vec3f octahedral_direction(float x, float y) {
  const float z = 1 - std::abs(x) - std::abs(y);
  if (z >= 0) return normalized(Vec3f{x, y, z});
  return normalized(Vec3f{std::copysign(1 - std::abs(y), x), std::copysign(1 - std::abs(x), y), z});
}
inline Vec2f octahedral_place(const Vec3f& d) {
  const float s = 1 / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z)), x = s * d.x, y = s * d.y;
  if (d.z >= 0) return {x, y};
  return {std::copysign(1 - std::abs(y), x), std::copysign(1 - std::abs(x), y)};
}

// Radiance HDR images (.hdr, .pic; Greg Ward): 8-bit RGB mantissas with a shared exponent, flat or run-length coded.
//   value = mantissa 2^(exponent - 136) / (EXPOSURE COLORCORR)
// EXPOSURE and COLORCORR are products over all header lines of that name, since every program that scales the image adds one.
// Rows and columns may be stored in any of eight orders. CIE XYZ is converted to RGB with Rec. 709 primaries and equal-energy
// white, the convention of Radiance.

// `name` is used in messages. `notes` receives one sentence per conversion. Throws Error{Input} (BAD_HDR) for damaged data.
ImageF parse_radiance_hdr(std::string_view bytes, const std::string& name, std::vector<std::string>* notes = nullptr);

}  // namespace vitrine
