// Depth from outside in the maps of stereo.
#include "core/observe/stereo/known_depth.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"

namespace vitrine {
namespace {

constexpr int kWidth = 32, kHeight = 24;

// Two cameras next to each other in front of the wall z = 2.
struct TwoPhotos {
  std::vector<StereoPhoto> photos{2};
  std::vector<DepthMap> maps;
  std::vector<KnownDepth> known{2};

  TwoPhotos() {
    constexpr size_t pixels = size_t(kWidth) * kHeight;
    for (uint32_t v = 0; v < 2; ++v) {
      photos[v].view.intrinsics = {kWidth, kHeight, 40, 40, kWidth / 2., kHeight / 2.};
      photos[v].view.cam_from_world = Rigid{Mat3d::identity(), {0.1 * v, 0, 0}};
      photos[v].neighbours = {1 - v};
      maps.push_back({kWidth, kHeight, std::vector<float>(pixels, 5.f), std::vector<Vec3f>(pixels, Vec3f{0, 0, -1}),
                      std::vector<float>(pixels, -1.f), std::vector<uint8_t>(pixels), std::vector<uint8_t>(pixels)});
      known[v] = {ImageF(kWidth, kHeight, 1, 2.f), std::vector<Vec3f>(pixels, Vec3f{0, 0, -1})};
    }
  }
};

TEST(KnownDepth, ReplacesStereoWhereTwoPhotosAgree) {
  TwoPhotos two;
  two.known[0].zdepth.at(10, 8) = 0;                   // unknown
  two.known[0].zdepth.at(12, 8) = 2.2f;                // in front of nothing that the other photo knows
  two.known[0].normal[two.maps[0].index(14, 8)] = {};  // without a surface
  const size_t replaced = join_known_depth(two.photos, two.known, two.maps);
  size_t found = 0;
  for (const DepthMap& map : two.maps)
    for (size_t i = 0; i < map.zdepth.size(); ++i) {
      EXPECT_NEAR(map.zdepth[i], map.reliable(i) ? 2.f : 5.f, 1e-6);
      found += map.reliable(i);
    }
  EXPECT_EQ(found, replaced);
  EXPECT_GT(replaced, size_t(1.6 * kWidth * kHeight));          // the border is seen by one photo alone
  EXPECT_TRUE(two.maps[0].reliable(two.maps[0].index(12, 8)));  // its neighbours show the wall: noise
  for (const int x : {10, 14}) EXPECT_FALSE(two.maps[0].reliable(two.maps[0].index(x, 8))) << x;
}

// Noise of 1 % of a slanted wall is smaller afterwards, and the edge to a second wall stays where it was.
TEST(KnownDepth, IsSmoothedAlongItsSurface) {
  TwoPhotos two;
  const Vec3d normal = normalized(Vec3d{0.4, 0.1, -1});
  const auto wall = [&](uint32_t v, int x, int y) {
    const Intrinsics& k = two.photos[v].view.intrinsics;
    const Vec3d ray = k.ray(x + 0.5, y + 0.5), eye{-0.1 * v, 0, 0};
    return (x < 20 ? 1 : 1.5) * dot(normal, Vec3d{0, 0, 2} - eye) / dot(normal, ray);
  };
  Rng rng(5);
  for (uint32_t v = 0; v < 2; ++v)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        two.known[v].zdepth.at(x, y) = float(wall(v, x, y) * (1 + 0.02 * (rng.uniform_double() + rng.uniform_double() - 1)));
        two.known[v].normal[two.maps[v].index(x, y)] = cast<float>(normal);
      }
  EXPECT_GT(join_known_depth(two.photos, two.known, two.maps), 200u);
  double before = 0, after = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const size_t i = two.maps[0].index(x, y);
      if (!two.maps[0].reliable(i)) continue;
      before += std::abs(double(two.known[0].zdepth.at(x, y)) / wall(0, x, y) - 1);
      after += std::abs(double(two.maps[0].zdepth[i]) / wall(0, x, y) - 1);
      EXPECT_LT(std::abs(double(two.maps[0].zdepth[i]) / wall(0, x, y) - 1), 0.02);
    }
  EXPECT_LT(after, 0.5 * before) << after << " " << before;
}

TEST(KnownDepth, ThatContradictsTheOtherPhotosChangesNothing) {
  TwoPhotos two;
  for (float& z : two.known[1].zdepth.data()) z = 2.3f;
  EXPECT_EQ(join_known_depth(two.photos, two.known, two.maps), 0u);
  two.known[1] = {};
  EXPECT_EQ(join_known_depth(two.photos, two.known, two.maps), 0u);
  EXPECT_EQ(two.maps[0].zdepth[0], 5.f);
}

TEST(KnownDepth, IsResampledWithoutMixingAcrossEdges) {
  ImageF map(12, 6, 1);
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 12; ++x) map.at(x, y) = x < 5 ? 1.f : 3.f + 0.001f * float(y);
  for (const auto& [w, h] : {std::pair{4, 2}, {3, 2}, {12, 6}, {36, 18}, {7, 5}}) {
    const ImageF other = resized_depth(map, w, h);
    for (const float z : other.data()) EXPECT_TRUE(z == 1.f || (z >= 3.f && z < 3.01f)) << w << " " << z;
    EXPECT_EQ(other.at(0, 0), 1.f);
    EXPECT_GE(other.at(w - 1, 0), 3.f);
  }
  for (int x = 0; x < 6; ++x) map.at(x, 0) = map.at(x, 1) = 0;
  EXPECT_EQ(resized_depth(map, 4, 2).at(0, 0), 0.f);  // two thirds are unknown
}

}  // namespace
}  // namespace vitrine
