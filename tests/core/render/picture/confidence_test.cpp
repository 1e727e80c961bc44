// Confidence of surfels: coverage by photos is tested with the page (tests/stages/view); here what training photos say of them.
#include "core/render/picture/confidence.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/scene/camera/projection.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

TEST(Confidence, IsThatOfTheMeanErrorWhereASurfelShows) {
  // Errors 0.05 and 0.15, over nine pixels; nothing shows the third.
  const auto c = confidence_of({.weight = {9, 9, 0}, .error = {0.45, 1.35, 0}});
  ASSERT_EQ(c.size(), 3u);
  EXPECT_NEAR(c[0], 0.5 * 0.9, 1e-6);
  EXPECT_NEAR(c[1], 0.25 * 0.9, 1e-6);
  EXPECT_EQ(c[2], 0);
  EXPECT_EQ(confidence_of({{1}, {0}})[0], 0.5f) << "a single pixel";
}

TEST(Confidence, IsLowWherePhotosDisagreeWithTheScene) {
  const test::TinyCapture capture;
  TrainedScene scene;
  scene.surfels.diffuse = capture.layer;
  ScenePainter painter(scene, {});
  const std::span<const View> training = std::span(capture.views).subspan(1);
  const auto upper_half_is_other = [&](const View& v) {
    View upright = v;
    ImageF photo = painter.picture(upright).srgb;
    const ImageF depth = painter.picture(upright).zdepth;
    for (int y = 0; y < photo.height(); ++y)
      for (int x = 0; x < photo.width(); ++x) {
        const double z = depth.at(x, y);
        if (!(z > 0)) continue;
        const Vec3d place = inverse(v.cam_from_world) * (z * v.intrinsics.ray(x + 0.5, y + 0.5));
        if (place.z > 0)
          for (int c = 0; c < 3; ++c)
            photo.at(x, y, c) = photo.at(x, y, c) > 0.5f ? photo.at(x, y, c) - 0.3f : photo.at(x, y, c) + 0.3f;
      }
    return photo;
  };
  const auto confidence = surfel_confidence(painter, training, upper_half_is_other);
  ASSERT_EQ(confidence.size(), capture.layer.size());
  size_t above = 0, below = 0;
  for (size_t i = 0; i < confidence.size(); ++i) {
    const float z = capture.layer.at(Attribute::Mean, i)[2];
    if (std::abs(z) < 0.1f || z < -0.15f || z > 0.3f) continue;  // cameras do not see the ball from below
    if (z > 0) {
      EXPECT_LT(confidence[i], 0.35f) << i;
      ++above;
    } else {
      EXPECT_GT(confidence[i], 0.5f) << i;
      ++below;
    }
  }
  EXPECT_GT(above, 100u);
  EXPECT_GT(below, 100u);

  const View& held_out = capture.views[0];
  const ImageF map = confidence_map(painter.surfels().diffuse, confidence, 0.01f, held_out);
  const auto at = [&](double z) {
    const auto p = image_point(held_out.cam_from_world * Vec3d{0.36, 0, z}, held_out.intrinsics, 0.01).value();
    return map.at(int(p.x), int(p.y));
  };
  EXPECT_EQ(map.at(0, 0), 0);
  EXPECT_LT(at(0.1), 0.6 * at(-0.1));
}

TEST(Confidence, AbsoluteErrorIsTheMeanOfTheChannels) {
  ImageF a(2, 1, 3, 0.5f), b = a;
  b.at(1, 0, 0) = 0.8f, b.at(1, 0, 2) = 0.2f;
  const ImageF error = absolute_error(a, b);
  EXPECT_EQ(error.at(0, 0), 0);
  EXPECT_NEAR(error.at(1, 0), 0.2, 1e-6);
}

}  // namespace
}  // namespace vitrine
