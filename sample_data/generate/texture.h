// Procedural colour: lattice noise and the baking of painted pictures into bitmaps. A texture maps a surface point to a
// linear diffuse albedo; everything that the structure-from-motion has to hold on to is made of these.
#pragma once

#include <cstdint>
#include <functional>
#include <numbers>

#include "core/scene/image/image.h"
#include "core/foundation/math/vec.h"

namespace vitrine::generate {

inline constexpr float kPi = std::numbers::pi_v<float>;

struct SurfacePoint {
  Vec3f position;  // world, metres
  Vec3f normal;    // unit, outwards
  Vec2f uv;        // metres from the corner of a flat part; 0 on curved parts
};
using Texture = std::function<Vec3f(const SurfacePoint&)>;  // linear albedo in [0,1]
using Painting = std::function<Vec3f(float x, float y)>;    // linear albedo over [0,width] x [0,height] in metres

uint32_t lattice_hash(int x, int y, int z, uint32_t seed);
inline float unit_float(uint32_t hash) { return static_cast<float>(hash >> 8) * 0x1p-24f; }

float value_noise(const Vec3f& p, uint32_t seed);                 // [0,1], quintic interpolation
float fractal_noise(const Vec3f& p, int octaves, uint32_t seed);  // [0,1], gain 1/2, lacunarity 2

struct CellNoise {
  float nearest = 0, second = 0;  // distances to the two nearest feature points
  uint32_t cell = 0;              // hash of the nearest cell
};
CellNoise cell_noise(const Vec3f& p, uint32_t seed);  // Worley 1996, one feature point a cell

Vec3f from_srgb8(int r, int g, int b);
inline Vec3f mixed(const Vec3f& a, const Vec3f& b, float t) { return a + t * (b - a); }
inline float smooth_step(float low, float high, float x) {
  const float t = x <= low ? 0.0f : x >= high ? 1.0f : (x - low) / (high - low);
  return t * t * (3.0f - 2.0f * t);
}

// The painting sampled 3x3 a texel and looked up bilinearly with the part's uv, clamped at the border.
Texture baked(const Painting& painting, float width, float height, float texel);

}  // namespace vitrine::generate
