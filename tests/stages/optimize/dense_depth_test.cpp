// The photos that stereo of the training photos compares.
#include "stages/optimize/initialise.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

TEST(DenseDepth, ComparesPhotosWithoutExposureAndWhiteBalance) {
  const TemporaryFolder folder("dense-depth");
  testing::write_tiny_sfm(folder.path());
  const auto lumas = [&] {
    std::vector<ImageF> out;
    const Capture capture = load_capture(folder.path(), 48, 8);
    for (const StereoPhoto& photo : dense_depth(capture, 48, 5, 1).photos) out.push_back(photo.luma);
    return out;
  };
  const std::vector<ImageF> before = lumas();
  const ViewSet set = load_view_set(folder.path());
  Gains gains;
  for (size_t v = 0; v < set.views.size(); ++v) {
    const Vec3d factor{0.6 + 0.04 * double(v), 0.8, 0.95 - 0.04 * double(v)};
    const auto file = linear_image_path(folder.path(), set.views[v]);
    ImageF linear = read_exr_rgb(file);
    for (size_t i = 0; i < linear.data().size(); ++i) linear.data()[i] *= float(factor[i % 3]);
    write_exr_rgb(file, linear);
    gains[set.views[v].name] = hadamard(factor, set.views[v].gain);
  }
  write_gains(folder.path() / "sfm/gains.json", gains);
  const std::vector<ImageF> after = lumas();
  ASSERT_EQ(before.size(), after.size());
  size_t compared = 0;
  for (size_t v = 0; v < before.size(); ++v)
    for (size_t i = 0; i < before[v].data().size(); ++i, ++compared)
      ASSERT_NEAR(before[v].data()[i], after[v].data()[i], 2e-3) << set.views[v].name;
  EXPECT_GT(compared, 0u);
}

// The first surface of the tiny scene: the ball, else the floor; z-depth and normal in the camera frame, at the size of a level.
KnownDepth surfaces_of(const View& view) {
  const Intrinsics& k = view.intrinsics;
  KnownDepth known{ImageF(k.width, k.height, 1), std::vector<Vec3f>(k.pixel_count())};
  const Vec3d eye = view.centre_in_world();
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const Vec3d ray = view.ray(x + 0.5, y + 0.5);  // 1 along the axis of the camera
      const double a = dot(ray, ray), b = dot(eye, ray), root = b * b - a * (dot(eye, eye) - 0.25 * 0.25);
      const double ball = root > 0 ? (-b - std::sqrt(root)) / a : 0, floor = (-0.3 - eye.z) / ray.z;
      const Vec3d at = eye + floor * ray;
      if (ball <= 0 && (floor <= 0 || std::abs(at.x) > 0.8 || std::abs(at.y) > 0.8)) continue;
      known.zdepth.at(x, y) = float(ball > 0 ? ball : floor);
      const Vec3d normal = ball > 0 ? (eye + ball * ray) / 0.25 : Vec3d{0, 0, 1};
      known.normal[k.index(x, y)] = cast<float>(view.cam_from_world.rotation * normal);
    }
  return known;
}

// Median relative error of the reliable pixels, and their share.
std::pair<double, double> errors_of(const DenseDepth& dense) {
  std::vector<double> errors;
  for (size_t v = 0; v < dense.photos.size(); ++v) {
    if (dense.maps[v].zdepth.empty()) continue;
    const KnownDepth truth = surfaces_of(dense.photos[v].view);
    for (size_t i = 0; i < truth.normal.size(); ++i)
      if (dense.maps[v].reliable(i) && truth.zdepth.data()[i] > 0)
        errors.push_back(std::abs(double(dense.maps[v].zdepth[i] / truth.zdepth.data()[i]) - 1));
  }
  std::nth_element(errors.begin(), errors.begin() + std::ptrdiff_t(errors.size() / 2), errors.end());
  return {errors[errors.size() / 2], dense.reliable_share()};
}

TEST(DenseDepth, TakesTheDepthOfTheUserWherePhotosAgree) {
  const TemporaryFolder folder("known-depth");
  testing::write_tiny_sfm(folder.path());
  const Capture capture = load_capture(folder.path(), 48, 8);
  const auto known = [&](uint32_t photo, size_t level) { return surfaces_of(capture.photos[photo].levels[level].view); };
  const auto [before, share_before] = errors_of(dense_depth(capture, 48, 5, 1));
  const auto [after, share_after] = errors_of(dense_depth(capture, 48, 5, 1, known));
  EXPECT_LT(after, 1e-4);
  EXPECT_LT(after, 0.1 * before);
  EXPECT_GT(share_after, share_before);
}

// Depth of the artifact, with the surfaces of the training's targets; none on glass and mirrors.
TEST(DenseDepth, OfTheUserIsReadWithTheNormalsAndNotOnMirrors) {
  const TemporaryFolder folder("known-depth");
  testing::write_tiny_sfm(folder.path());
  const Capture capture = load_capture(folder.path(), 48, 8);
  Targets targets;
  targets.photos.resize(capture.photos.size());
  EXPECT_FALSE(known_depth_of(capture, targets, folder.path()));  // no depth/
  EXPECT_FALSE(known_depth_of(capture, targets, std::nullopt));
  const View& view = capture.view_set.views[1];
  const Intrinsics& k = capture.photos[1].levels[0].view.intrinsics;
  make_folders(folder.path() / "depth");
  write_exr(known_depth_path(folder.path(), view),
            {.pixels = ImageF(2 * k.width, 2 * k.height, 1, 1.5f), .channels = {"Z"}, .attributes = {}}, ExrPrecision::Float);
  TargetLevel& level = targets.photos[1][0];
  level.normals.assign(3 * k.pixel_count(), 0);
  for (size_t i = 0; i + 5 < k.pixel_count(); ++i) level.normals[2 * k.pixel_count() + i] = -32767;
  level.masks[size_t(MaskClass::Specular)].assign(k.pixel_count(), 0);
  level.masks[size_t(MaskClass::Specular)][7] = 255;
  const KnownDepthOf known = known_depth_of(capture, targets, folder.path());
  ASSERT_TRUE(known);
  const KnownDepth found = known(1, 0);
  ASSERT_EQ(found.zdepth.pixel_count(), k.pixel_count());
  EXPECT_EQ(found.zdepth.data()[6], 1.5f);
  EXPECT_EQ(found.zdepth.data()[7], 0);
  EXPECT_EQ(found.normal[6], (Vec3f{0, 0, -1}));
  EXPECT_EQ(found.normal[k.pixel_count() - 1], Vec3f{});
  EXPECT_TRUE(known(2, 0).empty());  // no map
}

}  // namespace
}  // namespace vitrine
