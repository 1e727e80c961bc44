// An object that is turned over between passes of photos, on a turntable, or from above alone: minutes.
#include "tests/captures/turned_fixture.h"

namespace vitrine {
namespace {

using test::ObjectCapture, test::PassCameras, test::Lying, test::TakenPhotos, test::TurnedObject, test::as_it_is,
    test::turned_over, test::kRotationDeg;

TEST_F(TurnedObject, TwoPassesAreJoinedByTheObject) {
  NEED_COLMAP();
  const ObjectCapture capture = written({&as_it_is(), &turned_over()});
  register_photos(capture, true);
  expect_all_in_the_frame_of_the_object(capture);
  expect_passes(capture);
  EXPECT_TRUE(sfm_->warnings.empty());
}

TEST_F(TurnedObject, ExposureAndWhiteBalanceMayChangeAndThePlateBeClipped) {
  NEED_COLMAP();
  const ObjectCapture capture = written({&as_it_is(), &turned_over()}, {.exposure_varies = true, .blue_gain = 0.8});
  register_photos(capture, true);
  expect_all_in_the_frame_of_the_object(capture);
  expect_passes(capture);
}

TEST_F(TurnedObject, ThreePassesAreJoinedByTheObjectWhereverTheChartLies) {
  NEED_COLMAP();
  const TakenPhotos on_its_side = test::photos_of_pass({.lying = Lying::OnItsSide, .photos = 14, .chart_place = 1});
  const ObjectCapture capture = written({&as_it_is(), &turned_over(), &on_its_side});
  register_photos(capture, true);
  expect_all_in_the_frame_of_the_object(capture);
  expect_passes(capture);
  EXPECT_TRUE(sfm_->warnings.empty());
}

TEST_F(TurnedObject, PassesThatShareNoSideAreNotJoined) {
  NEED_COLMAP();
  // Four fifths of the photos in one pass: sfm does not climb its ladder of retries (kRetryBelow), which would only take
  // time.
  const TakenPhotos top = test::photos_of_pass({.photos = 20, .cameras = PassCameras::Above});
  const TakenPhotos underside = test::photos_of_pass({.lying = Lying::TurnedOver, .photos = 5, .cameras = PassCameras::Above});
  const ObjectCapture capture = written({&top, &underside});
  register_photos(capture, true);
  EXPECT_TRUE(warned("SFM_PASSES_NOT_JOINED"));
  std::vector<std::string> registered;
  for (const View& view : load_view_set(sfm_->output()).views) registered.push_back(view.name);
  EXPECT_EQ(registered, capture.passes().front());
  EXPECT_LT(errors_.rotation_deg, kRotationDeg);
}

TEST_F(TurnedObject, OneTurnOnATurntableIsOnePass) {
  NEED_COLMAP();
  const TakenPhotos turning = test::photos_on_turntable(18);
  const ObjectCapture capture = written({&turning});
  register_photos(capture, true);
  expect_all_in_the_frame_of_the_object(capture);
  expect_one_pass();
}

}  // namespace
}  // namespace vitrine
