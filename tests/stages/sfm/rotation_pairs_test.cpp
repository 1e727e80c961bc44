// Homographies of a camera that turned, and of a plane seen from two places.
#include "stages/sfm/rotation_pairs.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/math/vec.h"

namespace vitrine {
namespace {

constexpr int kPanWidth = 640, kPanHeight = 480;
constexpr double kFocal = 600;

VerifiedPair pair_of(const Mat3d& euclidean) {
  const Mat3d k{{kFocal, 0, 0}, {0, kFocal, 0}, {320, 240, 1}},
      inverse{{1 / kFocal, 0, 0}, {0, 1 / kFocal, 0}, {-320 / kFocal, -240 / kFocal, 1}};
  const Mat3d h = k * euclidean * inverse;
  return {.image_a = 1,
          .image_b = 2,
          .inliers = 100,
          .config = 6,
          .homography = {h.c0.x, h.c1.x, h.c2.x, h.c0.y, h.c1.y, h.c2.y, h.c0.z, h.c1.z, h.c2.z}};
}

Mat3d turned(double degrees) {
  const double a = degrees * 3.14159265358979 / 180;
  return {{std::cos(a), 0, -std::sin(a)}, {0, 1, 0}, {std::sin(a), 0, std::cos(a)}};
}

TEST(RotationPairs, KnowATurnFromAPlane) {
  std::vector<VerifiedPair> turns, planes, still;
  for (int i = 1; i <= 6; ++i) {
    turns.push_back(pair_of(turned(5.0 * i)));
    still.push_back(pair_of(turned(0)));
    Mat3d plane = turned(4.0 * i);  // R + t n^T / d, with n = z
    plane.c2 += Vec3d{0.12 * i, 0.02, 0.05 * i};
    planes.push_back(pair_of(plane));
  }
  EXPECT_EQ(rotation_share(turns, kPanWidth, kPanHeight), 1);
  EXPECT_LE(rotation_share(planes, kPanWidth, kPanHeight), 0.34)
      << "one focal length can make one plane look like a turn, not all";
  EXPECT_EQ(rotation_share(still, kPanWidth, kPanHeight), 0);
  for (VerifiedPair& p : turns) p.config = kCalibratedPair;
  EXPECT_EQ(rotation_share(turns, kPanWidth, kPanHeight), 0) << "they have depth";
}

}  // namespace
}  // namespace vitrine
