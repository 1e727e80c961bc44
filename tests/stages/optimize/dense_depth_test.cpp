// The photos that stereo of the training photos compares.
#include "stages/optimize/initialise.h"

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

}  // namespace
}  // namespace vitrine
