#include "stages/evaluate/alignment.h"

#include <numbers>

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/rng.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

using test::looking_at;

Vec3d random_point(Rng& rng) { return {rng.normal(), rng.normal(), rng.normal()}; }
Similarity random_similarity(Rng& rng) {
  const Quatd q = normalized(Quatd{rng.normal(), rng.normal(), rng.normal(), rng.normal()});
  return {0.3 + 2 * rng.uniform_double(), rotation_matrix(q), random_point(rng)};
}
void expect_near(const Similarity& a, const Similarity& b, double tolerance) {
  EXPECT_NEAR(a.scale, b.scale, tolerance);
  for (size_t r = 0; r < 3; ++r) {
    EXPECT_NEAR(a.translation[r], b.translation[r], tolerance);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(a.rotation(r, c), b.rotation(r, c), tolerance);
  }
}
std::vector<CameraPair> ring(const Similarity& truth_from_ours, size_t n) {
  std::vector<CameraPair> cameras;
  for (size_t i = 0; i < n; ++i) {
    const double a = 2 * std::numbers::pi * double(i) / double(n);
    const Rigid ours = looking_at({std::cos(a), std::sin(a), 0.3}, {0, 0, 0});
    cameras.push_back({ours, transformed_world(ours, truth_from_ours)});
  }
  return cameras;
}

TEST(Umeyama, RecoversExactSimilarities) {
  Rng rng(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Similarity truth = random_similarity(rng);
    std::vector<Vec3d> from, to;
    for (int i = 0; i < 3 + trial; ++i) {
      from.push_back(random_point(rng));
      to.push_back(truth * from.back());
    }
    expect_near(umeyama(from, to), truth, 1e-9);
  }
}

TEST(Umeyama, GivesARotationForPlanarPointsNotAReflection) {
  Rng rng(2);
  const Similarity truth = random_similarity(rng);
  std::vector<Vec3d> from, to;
  for (int i = 0; i < 8; ++i) {
    from.push_back({rng.normal(), rng.normal(), 0});
    to.push_back(truth * from.back());
  }
  const Similarity found = umeyama(from, to);
  expect_near(found, truth, 1e-9);
  EXPECT_NEAR(dot(found.rotation * Vec3d{1, 0, 0}, cross(found.rotation * Vec3d{0, 1, 0}, found.rotation * Vec3d{0, 0, 1})), 1,
              1e-12);
}

TEST(Umeyama, MatchesAHandComputedLeastSquaresFit) {
  // Targets stretched by 2 along x and 1 along y: the best isotropic scale of the unit cross is 1.5, no rotation.
  const std::vector<Vec3d> from{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}, to{{2, 0, 0}, {-2, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  expect_near(umeyama(from, to), {1.5, Mat3d::identity(), {0, 0, 0}}, 1e-12);
}

TEST(AlignCameras, OneMisplacedCameraDoesNotTiltTheScene) {
  Rng rng(3);
  const Similarity truth = random_similarity(rng);
  std::vector<CameraPair> cameras = ring(truth, 20);
  cameras[4].ours = looking_at({3, -2, 4}, {0, 0, 0});
  const Alignment a = align_cameras(cameras, "truth");
  EXPECT_EQ(a.used, 19u);
  expect_near(a.truth_from_ours, truth, 1e-9);
}

TEST(AlignCameras, CentresOnALineAreTurnedByTheOrientations) {
  Rng rng(4);
  const Similarity truth = random_similarity(rng);
  std::vector<CameraPair> cameras;
  for (int i = 0; i < 5; ++i) {
    const Rigid ours = looking_at({double(i), 0, 0}, {2, 5, 1});
    cameras.push_back({ours, transformed_world(ours, truth)});
  }
  const Alignment a = align_cameras(cameras, "truth");
  EXPECT_TRUE(a.by_orientations);
  expect_near(a.truth_from_ours, truth, 1e-9);
}

TEST(AlignCameras, TooFewOrCoincidingCamerasAreAnInputError) {
  const std::vector<CameraPair> one = ring({}, 1), same(4, one[0]);
  for (const auto& cameras : {one, same, std::vector<CameraPair>{}}) {
    try {
      align_cameras(cameras, "truth/transforms.json");
      FAIL();
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::Input);
      EXPECT_EQ(e.detail().where, "truth/transforms.json");
    }
  }
}

TEST(PoseErrors, AreTheAngleAndTheDistanceThatWereAdded) {
  const Similarity truth_from_ours{2.5, rotation_matrix(normalized(Quatd{1, 0.2, -0.4, 0.1})), {3, 1, -2}};
  std::vector<CameraPair> cameras = ring(truth_from_ours, 12);
  // Camera 3 is turned by 2 degrees about its own x axis: the centre stays.
  const double half = 1.0 * std::numbers::pi / 180;
  const Mat3d turn = rotation_matrix(Quatd{std::cos(half), std::sin(half), 0, 0});
  cameras[3].ours = {turn * cameras[3].ours.rotation, turn * cameras[3].ours.translation};
  // Camera 7 is moved by 1 % of the ring.
  const double radius = ring_radius(cameras) / 2.5;
  const Vec3d centre = inverse(cameras[7].ours).translation;
  cameras[7].ours.translation = -(cameras[7].ours.rotation * (centre + Vec3d{0, 0, 0.01 * radius}));
  const auto errors = pose_errors(cameras, truth_from_ours);
  EXPECT_NEAR(errors[3].rotation_deg, 2, 1e-9);
  EXPECT_NEAR(errors[3].centre_rel, 0, 1e-12);
  EXPECT_NEAR(errors[7].rotation_deg, 0, 1e-6);
  EXPECT_NEAR(errors[7].centre_rel, 0.01, 1e-9);
  EXPECT_NEAR(ring_radius(cameras), 2.5, 1e-9);  // the ring's plane is lifted, its centroid with it
}

}  // namespace
}  // namespace vitrine
