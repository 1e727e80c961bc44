#include "core/scene/camera/view.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vitrine {
namespace {

View looking(const Vec3d& centre, const Vec3d& forward) {
  const Vec3d z = normalized(forward), x = normalized(cross(z, Vec3d{0.1, 0.2, 1})), y = cross(z, x);
  View v;
  v.cam_from_world = inverse(Rigid{Mat3d{x, y, z}, centre});
  return v;
}

TEST(ViewingAxes, MeetWhereAllLook) {
  const Vec3d there{0.3, -0.2, 0.7};
  std::vector<View> ring;
  for (int i = 0; i < 7; ++i) {
    const Vec3d eye{2 * std::cos(0.5 * i), 2 * std::sin(0.5 * i), 0.3 * i};
    ring.push_back(looking(eye, there - eye));
  }
  const LookedAt found = looked_at(ring);
  EXPECT_LT(length(found.point - there), 1e-12);
  EXPECT_GT(found.spread, 0.1);
}

TEST(ViewingAxes, OfParallelCamerasHaveNoSpread) {
  std::vector<View> row;
  for (int i = 0; i < 5; ++i) row.push_back(looking({double(i), 0, 0}, {0, 1, 0.2}));
  const LookedAt found = looked_at(row);
  EXPECT_LT(found.spread, 1e-12);
  EXPECT_TRUE(std::isfinite(found.point.x + found.point.y + found.point.z));
  // Two that look at each other: one axis.
  const std::vector<View> facing{looking({-1, 0, 0}, {1, 0, 0}), looking({1, 0, 0}, {-1, 0, 0})};
  EXPECT_LT(looked_at(facing).spread, 1e-12);
}

TEST(ViewingAxes, InAllDirectionsHaveTheLargestSpread) {
  std::vector<View> six;
  for (size_t axis = 0; axis < 3; ++axis)
    for (double sign : {-1.0, 1.0}) {
      Vec3d d{};
      d[axis] = sign;
      six.push_back(looking(3.0 * d, -d));
    }
  EXPECT_NEAR(looked_at(six).spread, 2.0 / 3, 1e-12);
}

}  // namespace
}  // namespace vitrine
