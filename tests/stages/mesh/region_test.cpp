#include "stages/mesh/mesh.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/rng.h"
#include "core/scene/camera/view_set.h"
#include "tests/core/scene/mesh/orbit.h"

namespace vitrine {
namespace {

TEST(Region, WideCaptureKeepsAllButOutliers) {
  ViewSet set;
  for (int i = 0; i < 20; ++i) {  // a street: side by side, looking ahead
    View v;
    v.intrinsics = {100, 100, 100, 100, 50, 50};
    v.cam_from_world = orbit::looking_at({0.1 * i - 1, 0, 0}, {0.1 * i - 1, 10, 0});
    set.views.push_back(v);
  }
  Rng rng(4);
  for (int i = 0; i < 1000; ++i) set.points.push_back({{4 * rng.uniform() - 2, 3 + 2 * rng.uniform(), rng.uniform()}, {}, 0, {}});
  set.points.push_back({{500, 900, 3}, {}, 0, {}});
  const Region region = scene_region(set, {});
  EXPECT_FALSE(region.convergent);
  EXPECT_NEAR(region.box.low.x, -2, 0.6);
  EXPECT_NEAR(region.box.high.y, 5, 0.6);
  set.points.resize(5);
  EXPECT_THROW(scene_region(set, {}), Error);
}

TEST(Region, WithoutPointsItLiesBetweenCamerasThatLookAtOnePlace) {
  ViewSet set;
  const Vec3d target{1, 2, 3};
  for (int i = 0; i < 8; ++i) {
    View v;
    v.intrinsics = {100, 100, 100, 100, 50, 50};
    v.cam_from_world = orbit::looking_at(target + Vec3d{2 * std::cos(0.7 * i), 2 * std::sin(0.7 * i), 0}, target);
    set.views.push_back(v);
  }
  const Region region = scene_region(set, {});
  EXPECT_TRUE(region.convergent);
  EXPECT_EQ(region.points, 0u);
  for (size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR((region.box.low[axis] + region.box.high[axis]) / 2, target[axis], 1e-9);
  EXPECT_NEAR(length(region.box.high - target), 2, 1e-9);  // its corners are as far away as the cameras
}

// A glass case on a table: masks keep features off the glass, so that sparse points lie on the table alone.
TEST(Region, HoldsGlassWhereNoFeaturesAre) {
  ViewSet set;
  for (int i = 0; i < 8; ++i) {
    View v;
    v.intrinsics = {100, 100, 100, 100, 50, 50};
    v.cam_from_world = orbit::looking_at({2 * std::cos(0.7 * i), 2 * std::sin(0.7 * i), 0.8}, {0, 0, 0.2});
    set.views.push_back(v);
  }
  Rng rng(4);
  for (int i = 0; i < 500; ++i) set.points.push_back({{rng.uniform() - 0.5, rng.uniform() - 0.5, 0}, {}, 0, {}});
  const Region without = scene_region(set, {});
  ASSERT_TRUE(without.convergent);
  EXPECT_LT(without.box.high.z, 0.2);

  SplatLayer layer(LayerKind::Diffuse, 0, 3000);
  for (size_t i = 0; i < layer.size(); ++i) {
    const bool glass = i < 1000, mirror = i >= 1000 && i < 2000;  // and walls, up to 1.2
    *layer.at(Attribute::Transmission, i) = glass ? 3 : -3;
    *layer.at(Attribute::SpecularWeight, i) = mirror ? 3 : -3;
    *layer.at(Attribute::Opacity, i) = i % 1000 < 900 ? 3 : -3;  // what can hardly be seen is higher yet
    float* p = layer.at(Attribute::Mean, i);
    p[0] = float(0.3 * rng.uniform()), p[1] = float(0.3 * rng.uniform());
    p[2] = float((glass ? 0.7 : mirror ? 0.5 : 1.2) * rng.uniform() + (i % 1000 < 900 ? 0 : 0.4));
  }
  layer.at(Attribute::Mean, 0)[2] = 1.1f;  // an outlier
  layer.at(Attribute::Mean, 1)[2] = 50.f;  // beyond reach
  const std::vector<Vec3d> places = glass_and_gloss(layer);
  EXPECT_EQ(places.size(), 1800u);
  const Region with = scene_region(set, {}, places);
  EXPECT_NEAR(with.box.high.z, 0.7 + 0.1 * 1.0, 0.05) << "a tenth of the longest side beside";
  EXPECT_NEAR(with.box.low.x, without.box.low.x, 0.02);
  EXPECT_EQ(with.points, without.points);

  // Pictures behind a flat mirror stand far behind it: voxels may not grow with them.
  std::vector<Vec3d> behind;
  for (int i = 0; i < 400; ++i) behind.push_back({0.3 * rng.uniform(), 0.1, 0.01 * i - 2});
  RegionDesc tight;
  tight.margin = 0;
  EXPECT_NEAR(scene_region(set, tight, behind).box.low.z, -1, 0.05);
  const std::vector<Vec3d> strays(behind.begin() + 100, behind.begin() + 115);  // within reach, below the table
  EXPECT_EQ(scene_region(set, {}, strays).box.low.z, without.box.low.z) << "too few to say anything";
}

}  // namespace
}  // namespace vitrine
