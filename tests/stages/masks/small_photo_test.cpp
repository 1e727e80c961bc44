// Photos at the size of masks: exposure and white balance are taken out, once.
#include "stages/masks/mask_source.h"

#include <gtest/gtest.h>

#include "core/observe/stereo/view_dependence.h"
#include "tests/stages/masks/ball_capture.h"

namespace vitrine::test {
namespace {

MaskCapture capture_of(const BallCapture& capture) {
  MaskCapture out;
  out.sfm_folder = capture.sfm();
  out.set = load_view_set(capture.sfm());
  return out;
}

TEST(SmallPhotos, AreAsBrightWhateverTheExposure) {
  const BallCapture capture;
  const std::vector<SmallPhoto> before = small_photos(capture_of(capture), 48);
  Gains gains;
  for (size_t v = 0; v < capture.views.size(); ++v) {
    const Vec3d gain{0.7 + 0.05 * double(v), 0.8, 1.1 - 0.04 * double(v)};
    const fs::path file = linear_image_path(capture.sfm(), capture.views[v]);
    ImageF linear = read_exr_rgb(file);
    for (size_t i = 0; i < linear.data().size(); ++i) linear.data()[i] *= float(gain[i % 3]);
    write_exr_rgb(file, linear);
    gains[capture.views[v].name] = gain;
  }
  write_gains(capture.sfm() / "sfm/gains.json", gains);
  const std::vector<SmallPhoto> after = small_photos(capture_of(capture), 48);
  ASSERT_EQ(before.size(), after.size());
  const auto luminance = [](const SmallPhoto& photo) {
    return luminance_photo(photo.view, linear_from_srgb_image(edge_photo(photo).srgb), 24).luminance;
  };
  for (size_t v = 0; v < before.size(); ++v) {
    for (size_t i = 0; i < before[v].srgb.size(); ++i) ASSERT_NEAR(before[v].srgb[i], after[v].srgb[i], 2e-3) << v;
    const ImageF a = luminance(before[v]), b = luminance(after[v]);  // what tells mirrors
    for (size_t i = 0; i < a.data().size(); ++i) ASSERT_NEAR(a.data()[i], b.data()[i], 2e-3) << v;
  }
}

}  // namespace
}  // namespace vitrine::test
