#include "sample_data/generate/texture.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/foundation/base/parallel.h"
#include "core/scene/image/resample.h"
#include "core/foundation/math/color.h"

namespace vitrine::generate {

namespace {

// Defined before its loops, so that it is inlined there.
inline uint32_t hash_of(int x, int y, int z, uint32_t seed) {
  uint32_t h = seed * 0x9e3779b9u ^ static_cast<uint32_t>(x) * 0x85ebca6bu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du ^ static_cast<uint32_t>(y) * 0xc2b2ae35u;
  h = (h ^ (h >> 13)) * 0x297a2d39u ^ static_cast<uint32_t>(z) * 0x27d4eb2fu;
  h = (h ^ (h >> 16)) * 0x7feb352du;
  h = (h ^ (h >> 15)) * 0x846ca68bu;
  return h ^ (h >> 16);
}

}  // namespace

uint32_t lattice_hash(int x, int y, int z, uint32_t seed) { return hash_of(x, y, z, seed); }

float value_noise(const Vec3f& p, uint32_t seed) {
  const float fx = std::floor(p.x), fy = std::floor(p.y), fz = std::floor(p.z);
  const int x = static_cast<int>(fx), y = static_cast<int>(fy), z = static_cast<int>(fz);
  const auto quintic = [](float t) { return t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f); };
  const float u = quintic(p.x - fx), v = quintic(p.y - fy), w = quintic(p.z - fz);
  // The hashes of the eight corners side by side, so that the compiler makes one vector of them.
  uint32_t hash[8];
  for (uint32_t c = 0; c < 8; ++c)
    hash[c] = hash_of(x + static_cast<int>(c & 1), y + static_cast<int>(c >> 1 & 1), z + static_cast<int>(c >> 2), seed);
  const auto mix = [](float a, float b, float t) { return a + t * (b - a); };
  const auto edge = [&](size_t c) { return mix(unit_float(hash[c]), unit_float(hash[c + 1]), u); };
  return mix(mix(edge(0), edge(2), v), mix(edge(4), edge(6), v), w);
}

float fractal_noise(const Vec3f& p, int octaves, uint32_t seed) {
  float sum = 0, weight = 0, gain = 1;
  Vec3f q = p;
  for (int i = 0; i < octaves; ++i) {
    sum += gain * value_noise(q, seed + static_cast<uint32_t>(i));
    weight += gain;
    gain *= 0.5f;
    q = 2.0f * q + Vec3f{17.3f, 9.1f, 5.7f};  // a shift, so that the lattices of two octaves do not meet
  }
  return sum / weight;
}

CellNoise cell_noise(const Vec3f& p, uint32_t seed) {
  const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y)), z = static_cast<int>(std::floor(p.z));
  CellNoise result{1e9f, 1e9f, 0};
  for (int k = z - 1; k <= z + 1; ++k)
    for (int j = y - 1; j <= y + 1; ++j)
      for (int i = x - 1; i <= x + 1; ++i) {
        const uint32_t h = hash_of(i, j, k, seed);
        const Vec3f feature{static_cast<float>(i) + unit_float(h), static_cast<float>(j) + unit_float(h * 0x9e3779b1u),
                            static_cast<float>(k) + unit_float(h * 0x85ebca77u)};
        const float distance = squared_length(feature - p);
        if (distance < result.nearest) {
          result.second = result.nearest;
          result.nearest = distance;
          result.cell = h;
        } else if (distance < result.second) {
          result.second = distance;
        }
      }
  return {std::sqrt(result.nearest), std::sqrt(result.second), result.cell};
}

Vec3f from_srgb8(int r, int g, int b) {
  return {linear_from_srgb(static_cast<float>(r) / 255.0f), linear_from_srgb(static_cast<float>(g) / 255.0f),
          linear_from_srgb(static_cast<float>(b) / 255.0f)};
}

Texture baked(const Painting& painting, float width, float height, float texel) {
  constexpr int kSide = 3;
  const int w = std::max(2, static_cast<int>(std::lround(width / texel)));
  const int h = std::max(2, static_cast<int>(std::lround(height / texel)));
  auto bitmap = std::make_shared<ImageF>(w, h, 3);
  parallel_for(static_cast<size_t>(h), 8, [&](size_t row) {
    for (int x = 0; x < w; ++x) {
      Vec3f sum{};
      for (int j = 0; j < kSide; ++j)
        for (int i = 0; i < kSide; ++i)
          sum += painting((static_cast<float>(x) + (static_cast<float>(i) + 0.5f) / kSide) * width / static_cast<float>(w),
                          (static_cast<float>(row) + (static_cast<float>(j) + 0.5f) / kSide) * height / static_cast<float>(h));
      for (int c = 0; c < 3; ++c)
        bitmap->at(x, static_cast<int>(row), c) = sum[static_cast<size_t>(c)] / static_cast<float>(kSide * kSide);
    }
  });
  return [bitmap, width, height, w, h](const SurfacePoint& s) {
    float rgb[3];
    sample_bilinear(*bitmap, static_cast<double>(s.uv.x / width * static_cast<float>(w)),
                    static_cast<double>(s.uv.y / height * static_cast<float>(h)), rgb);
    return Vec3f{rgb[0], rgb[1], rgb[2]};
  };
}

}  // namespace vitrine::generate
