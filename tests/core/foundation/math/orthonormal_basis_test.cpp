#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/vec.h"

namespace vitrine {
namespace {

TEST(OrthonormalBasis, IsOrthonormalAndRightHandedForEveryDirectionAndAxis) {
  Rng rng(4);
  std::vector<Vec3d> directions{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  for (int i = 0; i < 300; ++i) directions.push_back(normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()}));
  for (const Vec3d& n : directions)
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto [u, v] = orthonormal_basis(n, axis);
      EXPECT_NEAR(length(u), 1, 1e-12);
      EXPECT_NEAR(dot(u, n), 0, 1e-12);
      EXPECT_NEAR(dot(v, n), 0, 1e-12);
      EXPECT_NEAR(dot(u, v), 0, 1e-12);
      EXPECT_NEAR(dot(cross(u, v), n), 1, 1e-12);
      if (std::abs(n[axis]) < 0.9) {
        EXPECT_EQ(u[axis], 0);
      }
    }
}

TEST(OrthonormalBasis, TakesTheNextAxisNearTheFirst) {
  EXPECT_EQ(orthonormal_basis(Vec3d{0, 0, 1}).u, (Vec3d{0, -1, 0}));
  EXPECT_EQ(orthonormal_basis(Vec3d{1, 0, 0}, 0).u, (Vec3d{0, 0, -1}));
  EXPECT_EQ(orthonormal_basis(Vec3f{1, 0, 0}).u, (Vec3f{0, 1, 0}));
}

}  // namespace
}  // namespace vitrine
