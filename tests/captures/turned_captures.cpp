// An object that is turned over between passes of photos: all photos are registered in the frame of the object, and the passes
// are found. More of the same, too long for every day, in long_turned_captures.cpp.
#include "tests/captures/turned_fixture.h"

namespace vitrine {
namespace {

using test::Lying, test::ObjectCapture, test::photos_of_pass, test::TakenPhotos, test::TurnedObject;

TEST_F(TurnedObject, IsNoticedWithoutMasks) {
  NEED_COLMAP();
  const TakenPhotos first = photos_of_pass({.photos = 12}), second = photos_of_pass({.lying = Lying::TurnedOver, .photos = 10});
  register_photos(written({&first, &second}), false);
  EXPECT_TRUE(warned("SFM_OBJECT_TURNED"));
}

TEST_F(TurnedObject, OnePassIsOnePass) {
  NEED_COLMAP();
  const TakenPhotos photos = photos_of_pass({.photos = 12});
  const ObjectCapture capture = written({&photos});
  register_photos(capture, true);
  expect_all_in_the_frame_of_the_object(capture);
  expect_one_pass();
}

}  // namespace
}  // namespace vitrine
