#include "stages/decompose/metals.h"

#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/render/model/kernels/fresnel.h"
#include "core/render/model/kernels/ggx.h"

namespace vitrine {
namespace {

constexpr Vec3f kBrass{0.9f, 0.7f, 0.4f};

std::vector<Vec3f> tiled_room(std::span<const Vec3f>, std::span<const Vec3f> directions) {
  std::vector<Vec3f> light;
  for (const Vec3f& d : directions) {
    const float tile = std::sin(9 * std::atan2(d.y, d.x)) * std::sin(8 * d.z);
    light.push_back(Vec3f{1, 0.9f, 0.8f} * (tile > 0.2f ? 0.6f : 0.15f));
  }
  return light;
}

// A ball seen by a far camera, whose normals are known with a bias of `off` radians.
MirroredPixels ball_of(float roughness, float off) {
  MirroredPixels pixels;
  constexpr int kSide = 64, kRays = 256;
  Rng rng(3);
  const Vec3f eye{1, 0, 0};
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const float u = (float(x) + 0.5f) / (kSide / 2) - 1, v = (float(y) + 0.5f) / (kSide / 2) - 1;
      if (u * u + v * v > 0.8f) continue;
      const Vec3f n{std::sqrt(1 - u * u - v * v), u, v};
      std::vector<Vec3f> directions;
      for (int s = 0; s < kRays; ++s) {
        const Vec3f h = ggx_half_vector(n, roughness * roughness, float(rng.uniform()), float(rng.uniform()));
        const Vec3f out = 2 * dot(eye, h) * h - eye;
        if (dot(out, n) > 0) directions.push_back(normalized(out));
      }
      Vec3f sum{};
      for (const Vec3f& light : tiled_room({}, directions)) sum += light / float(directions.size());
      pixels.view.push_back(0), pixels.x.push_back(x), pixels.y.push_back(y);
      pixels.origins.push_back(n);
      pixels.normals.push_back(normalized(n + Vec3f{0, off * std::sin(3 * v), off}));
      pixels.towards_eye.push_back(eye);
      pixels.photo.push_back(hadamard(schlick(kBrass, n.x).value, sum));
    }
  return pixels;
}

TEST(MetalRoughness, IsFoundWhereverNormalsLook) {
  for (const float off : {0.f, 0.1f})
    for (const float truth : {0.1f, 0.22f, 0.35f}) {
      const auto found = roughness_of_contrast(ball_of(truth, off), kBrass, tiled_room);
      ASSERT_TRUE(found);
      fmt::print("normals {:.1f} off: {:.2f} found as {:.3f}\n", off, truth, *found);
      EXPECT_NEAR(*found, truth, 0.05) << off;
    }
}

TEST(MetalRoughness, FewPixelsTellNothing) {
  MirroredPixels pixels = ball_of(0.2f, 0);
  const auto keep = [](auto& v) { v.resize(150); };
  keep(pixels.view), keep(pixels.x), keep(pixels.y), keep(pixels.photo);
  keep(pixels.origins), keep(pixels.normals), keep(pixels.towards_eye);
  EXPECT_FALSE(roughness_of_contrast(pixels, kBrass, tiled_room));
  EXPECT_FALSE(roughness_of_contrast({}, kBrass, tiled_room));
}

}  // namespace
}  // namespace vitrine
