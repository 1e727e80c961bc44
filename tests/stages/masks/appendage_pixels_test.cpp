// What sticks out of a solid in a picture, a spout, and what hulls have beside its root.
#include "stages/masks/boxes/outlines.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vitrine {
namespace {

// A disk with a bar, and beside the bar's root a hump that hulls have along the disk.
TEST(Marks, WhatSticksOutIsThereUpToItsRootAndNothingBesideIt) {
  Intrinsics k;
  k.width = 120, k.height = 80;
  const size_t pixels = k.pixel_count();
  std::vector<uint8_t> solid(pixels), off(pixels), far(pixels), bar(pixels), hump(pixels);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const size_t p = k.index(x, y);
      const double r = std::hypot(x - 40, y - 40);
      solid[p] = r < 30;
      bar[p] = !solid[p] && x > 40 && x < 100 && std::abs(y - 40) < 5;
      hump[p] = !solid[p] && r < 34 && x > 40 && y > 48 && y < 62;
      off[p] = bar[p] || hump[p];
      far[p] = off[p] && r > 40;
    }
  const std::vector<uint8_t> found = with_appendages(solid, off, far, k);
  size_t lost = 0, kept = 0, humps = 0;
  for (size_t p = 0; p < pixels; ++p) {
    if (solid[p]) {
      EXPECT_TRUE(found[p]);
    }
    lost += bar[p] && !found[p], kept += hump[p] && found[p], humps += hump[p];
    EXPECT_FALSE(found[p] && !solid[p] && !off[p]);
  }
  EXPECT_EQ(lost, 0u);
  EXPECT_GT(humps, 40u);
  EXPECT_LT(kept, humps / 4) << "of " << humps;  // the pixels next to the bar
  EXPECT_EQ(with_appendages(solid, off, std::vector<uint8_t>(pixels), k), solid) << "nothing is far";
  EXPECT_EQ(with_appendages(std::vector<uint8_t>(pixels), off, far, k), far) << "the solid is beside the picture";
}

}  // namespace
}  // namespace vitrine
