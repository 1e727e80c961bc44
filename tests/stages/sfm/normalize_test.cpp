#include "stages/sfm/normalize.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/intake/poses/synthetic_model.h"

namespace vitrine {
namespace {

double degrees_between(const Vec3d& a, const Vec3d& b) {
  return std::acos(std::clamp(dot(normalized(a), normalized(b)), -1.0, 1.0)) * 180 / std::numbers::pi;
}

const Vec3d kUps[] = {{0, 0, 1}, {0, -1, 0}, {0.6, 0.48, -0.64}};

TEST(SceneUp, LevelRingGivesItsAxis) {
  for (const Vec3d& up : kUps) {
    const Orientation o = scene_up(synthetic_model(ring(24, 3, 1.5, up), cloud(100, 1)));
    EXPECT_LT(degrees_between(o.up, up), 1e-5);
    EXPECT_EQ(o.method, UpMethod::Ring);
  }
}

TEST(SceneUp, UnevenHandheldArcIsLevelledByItsCameras) {
  for (const Vec3d& up : kUps) {
    // Two partial arcs at different heights (no flat ring), 2 degrees of roll, and two photos tilted by 30 degrees.
    std::vector<Rigid> cameras = ring(12, 3, 0.4, up, 0.035, 2.4);
    for (const Rigid& c : ring(12, 2.5, 2.0, up, 0.035, 2.0)) cameras.push_back(c);
    const Vec3d a = inverse(cameras[3]).translation, b = inverse(cameras[17]).translation;
    cameras.push_back(camera_looking(1.02 * a, {}, up, 0.5));
    cameras.push_back(camera_looking(1.02 * b, {}, up, 0.5));
    const Orientation o = scene_up(synthetic_model(cameras, cloud(100, 1)));
    EXPECT_EQ(o.method, UpMethod::Level);
    EXPECT_LT(degrees_between(o.up, up), 1.0);  // worst seen 0.6
    EXPECT_GT(degrees_between(scene_up(synthetic_model(cameras, cloud(100, 1)), UpMethod::Mean).up, up),
              1.0);  // the naive answer is worse
  }
}

TEST(SceneUp, WalkAlongAWallUsesTheMeanUp) {
  for (const Vec3d& up : kUps) {
    const Vec3d right = normalized(cross(up, {0.3, 0.9, 0.1})), forward = cross(up, right);
    std::vector<Rigid> cameras;
    for (int i = 0; i < 12; ++i) cameras.push_back(camera_looking(0.3 * i * right, 0.3 * i * right + 3.0 * forward, up));
    std::vector<Vec3d> wall;
    for (const Vec3d& p : cloud(200, 3)) wall.push_back(3.0 * forward + (2 + 4 * p.x) * right + p.y * up);
    const Orientation o = scene_up(synthetic_model(cameras, wall));
    EXPECT_EQ(o.method, UpMethod::Mean);
    EXPECT_LT(degrees_between(o.up, up), 1e-5);
  }
}

TEST(SceneUp, DroneLookingDownSeesTheGroundBelow) {
  for (const bool turns : {true, false})
    for (const Vec3d& up : kUps) {
      const Vec3d east = normalized(cross(up, {0.3, 0.9, 0.1})), north = cross(up, east);
      std::vector<Rigid> cameras;
      for (int row = 0; row < 4; ++row)
        for (int i = 0; i < 5; ++i) {
          const Vec3d at = double(i) * east + double(row) * north + 1.5 * up;
          cameras.push_back(camera_looking(at, at - up, turns && row % 2 ? -north : north));
        }
      std::vector<Vec3d> ground;
      for (const Vec3d& p : cloud(800, 3)) ground.push_back((2 + 6 * p.x) * east + (1.5 + 5 * p.y) * north + 0.1 * p.z * up);
      const Orientation o = scene_up(synthetic_model(cameras, ground));
      EXPECT_EQ(o.method, UpMethod::Nadir);
      EXPECT_LT(degrees_between(o.up, up), 0.5);
    }
}

TEST(SceneFrame, CentresLevelsAndScalesTheCameras) {
  for (const Vec3d& up : kUps) {
    ColmapModel model = synthetic_model(ring(20, 3, 1.5, up), cloud(100, 1));
    transform_world(
        model, {.scale = 7, .rotation = rotation_matrix(normalized(Quatd{0.9, 0.2, -0.3, 0.1})), .translation = {5, -3, 11}});
    const ColmapModel before = model;
    const Similarity s = scene_from_colmap(model, scene_up(model));
    transform_world(model, s);
    Vec3d centroid{};
    double farthest = 0;
    for (const ColmapImage& image : model.images) {
      const Vec3d c = inverse(image.cam_from_world()).translation;
      centroid += c / double(model.images.size());
      farthest = std::max(farthest, length(c));
      EXPECT_NEAR(c.z, 0, 1e-9);  // the ring is level
    }
    EXPECT_LT(length(centroid), 1e-9);
    EXPECT_NEAR(farthest, 1, 1e-9);
    EXPECT_NEAR(determinant(s.rotation), 1, 1e-12);
    // Points lie below the ring, and the inverse goes back.
    EXPECT_LT(model.points[0].position.z, 0);
    EXPECT_LT(length(inverse(s) * model.points[0].position - before.points[0].position), 1e-9);
  }
}

TEST(SceneFrame, FivePercentOfStraysDoNotSetTheScale) {
  std::vector<Rigid> cameras = ring(39, 2, 1, {0, 0, 1});
  cameras.push_back(camera_looking({0, 40, 1}, {}, {0, 0, 1}));
  const ColmapModel model = synthetic_model(cameras, cloud(100, 1));
  EXPECT_NEAR(scene_from_colmap(model, scene_up(model)).scale, 1 / 3.0, 0.05);  // ring 2 plus the centroid's shift of 1
}

}  // namespace
}  // namespace vitrine
