// How photos judge the layers of a scene against its opaque twin.
#include "stages/optimize/outputs.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/math/color.h"
#include "core/render/model/opaque_pass.h"
#include "tests/core/render/model/ball_before_wall.h"

namespace vitrine {
namespace {

// A ball before a wall, in one photo that judges.
class JudgedBall : public ::testing::Test {
 protected:
  JudgedBall() {
    ball_.room.view.name = "a.png";
    ball_.room.scene.opaque = ball_.room.scene.diffuse;
    SplatLayer& twin = ball_.room.scene.opaque;
    for (size_t i = 0; i < twin.size(); ++i) twin.at(Attribute::ShDc, i)[0] += 1;
    frame_.differentiable = false;
    LayeredModel(ball_.options).forward(ball_.room.scene, ball_.room.view, frame_);
    OpaquePicture picture(Backend::Reference);
    const auto opaque = picture.draw(ball_.room.scene, ball_.room.view, ball_.options);
    opaque_.assign(opaque.begin(), opaque.end());
    capture_.photos.resize(1);
    capture_.train = {0};
    targets_.photos.resize(1);
    std::vector<uint8_t>& specular = targets_.photos[0][0].masks[size_t(MaskClass::Specular)];
    for (const uint32_t entry : shapes_shown(frame_)) specular.push_back(entry != 0 ? 255 : 0);
  }
  // Of the ball, where the photo shows `share` of the layers and the rest of the twin.
  double judged(double share) {
    PhotoLevel& level = capture_.photos[0].levels[0];
    level.view = ball_.room.view;
    level.srgb.clear();
    for (size_t i = 0; i < opaque_.size(); ++i) {
      const double gain = ball_.room.view.gain[i / frame_.pixel_count()];
      const double light = gain * (share * double(frame_.linear[i]) + (1 - share) * double(opaque_[i]));
      level.srgb.push_back(uint16_t(std::lround(65535 * srgb_from_linear(std::clamp(light, 0.0, 1.0)))));
    }
    const std::vector<uint8_t> judges{1};
    return layered_shares(ball_.room.scene, ball_.options, capture_, targets_, judges).at(0);
  }

  BallBeforeWall ball_;
  Frame frame_;
  std::vector<float> opaque_;
  Capture capture_;
  Targets targets_;
};

TEST_F(JudgedBall, HasTheShareThatThePhotoShows) {
  EXPECT_NEAR(judged(1), 1, 1e-9);
  EXPECT_NEAR(judged(0), 0, 1e-9);
  EXPECT_NEAR(judged(0.7), 0.7, 0.026);
}

TEST_F(JudgedBall, IsJudgedWhereTrainingDidNotLookAlone) {
  std::vector<uint8_t>& specular = targets_.photos[0][0].masks[size_t(MaskClass::Specular)];
  std::vector<uint8_t>& ignored = targets_.photos[0][0].masks[size_t(MaskClass::Ignore)];
  ignored.assign(specular.size(), 255);
  EXPECT_EQ(judged(1), 0.5) << "ignored";
  ignored.clear();
  std::vector<uint8_t>& object = targets_.photos[0][0].masks[size_t(MaskClass::Object)];
  object.assign(specular.size(), 0);
  EXPECT_EQ(judged(1), 0.5) << "outside of the object that is trained alone";
  object.clear();
  specular.clear();
  EXPECT_EQ(judged(1), 0.5) << "no mask: nothing was withheld";
}

TEST(JudgingPhotos, AreEveryTwentiethOfTheTrainingPhotos) {
  Capture capture;
  capture.photos.resize(50);
  for (uint32_t i = 0; i < 50; i += 1 + (i % 8 == 7)) capture.train.push_back(i);
  const std::vector<uint8_t> judges = judging_photos(capture);
  EXPECT_EQ(std::ranges::count(judges, 1), 2);
  EXPECT_EQ(judges[capture.train[4]], 1);
  EXPECT_EQ(judges[capture.train[24]], 1);
  EXPECT_EQ(judging_photos({}).size(), 0u);
}

}  // namespace
}  // namespace vitrine
