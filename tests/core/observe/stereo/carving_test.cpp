// Which points silhouettes leave of space.
#include "core/observe/stereo/carving.h"

#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

constexpr double kBallRadius = 0.3;

std::vector<Silhouette> ball(int count) {
  return silhouettes_of_rays(count, 2 * std::numbers::pi,
                             [](const Vec3d& eye, const Vec3d& d) { return meets_ball({}, kBallRadius, eye, d); });
}

TEST(Carving, OccupancyIsTheSoftFormOfInside) {
  const std::vector<Silhouette> silhouettes = ball(24);
  const Carving carving(silhouettes, {});
  Rng rng(3, 1);
  std::vector<float> scratch;
  size_t in = 0, out = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3d p = 0.45 * Vec3d{2 * rng.uniform_double() - 1, 2 * rng.uniform_double() - 1, 2 * rng.uniform_double() - 1};
    if (std::abs(length(p) - kBallRadius) < 0.03) continue;  // pixels
    const bool inside = length(p) < kBallRadius;
    EXPECT_EQ(carving.inside(p), inside);
    EXPECT_EQ(carving.occupancy(p, scratch) >= 0.5f, inside);
    (inside ? in : out) += 1;
  }
  EXPECT_GT(in, 300u);
  EXPECT_GT(out, 300u);
}

TEST(Carving, SlackWidensSilhouettesByAsMuch) {
  const std::vector<Silhouette> silhouettes = ball(24);
  const Carving carving(silhouettes, {.outlier_share = 0}, true);
  const Vec3d beside{kBallRadius + 0.05, 0, 0};
  EXPECT_FALSE(carving.inside(beside));
  EXPECT_FALSE(carving.inside(beside, 0, 0.02));
  EXPECT_TRUE(carving.inside(beside, 0, 0.08));
}

TEST(Carving, UnknownPixelsDoNotContradict) {
  std::vector<Silhouette> silhouettes = ball(24);
  const Vec3d beside{kBallRadius + 0.1, 0, 0};
  const CarvingRule rule{.outlier_share = 0, .fewest_views = 0, .seen_share = 0};
  EXPECT_FALSE(Carving(silhouettes, rule).inside(beside));
  for (Silhouette& s : silhouettes)
    for (float& v : s.value.data()) v = v > 0 ? v : -1;
  EXPECT_TRUE(Carving(silhouettes, rule).inside(beside));
  EXPECT_FALSE(Carving(silhouettes, {.outlier_share = 0, .fewest_views = 20}).inside(beside)) << "too few photos show it inside";
}

}  // namespace
}  // namespace vitrine
