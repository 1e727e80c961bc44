// An object that is turned over between passes of photos: all photos are registered in the frame of the object, and the passes
// are found. More of the same, too long for every day, in long_turned_captures.cpp.
#include "tests/captures/turned_fixture.h"

namespace vitrine {
namespace {

using test::ObjectCapture, test::PassCameras, test::Lying, test::TakenPhotos, test::TurnedObject, test::as_it_is,
    test::turned_over, test::kRotationDeg;

TEST_F(TurnedObject, IsNoticedWithoutMasks) {
  NEED_COLMAP();
  register_photos(written({&as_it_is(), &turned_over()}), false);
  EXPECT_TRUE(warned("SFM_OBJECT_TURNED"));
}

TEST_F(TurnedObject, OnePassIsOnePass) {
  NEED_COLMAP();
  const ObjectCapture capture = written({&as_it_is()});
  register_photos(capture, true);
  expect_all_in_the_frame_of_the_object(capture);
  expect_one_pass();
}

}  // namespace
}  // namespace vitrine
