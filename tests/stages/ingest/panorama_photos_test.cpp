#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/panorama_views.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "stages/ingest/ingest.h"
#include "tests/support/recording_context.h"
#include "tests/support/sphere_picture.h"

namespace vitrine {
namespace {

using test::RecordingContext;

TEST(PanoramaPhotos, AreCutIntoTenViewsOfOneRig) {
  const TemporaryFolder folder;
  const fs::path photos = folder.path() / "photos";
  make_folders(photos / "b");  // a photo lies where the views of b.png would
  const ImageF panorama = test::sphere_panorama(512, 1);
  write_ldr(photos / "a.jpg", srgb8_from_linear(panorama), 98);
  write_ldr(photos / "b.png", srgb8_from_linear(test::sphere_panorama(512, 2)));
  write_ldr(photos / "b" / "view_00.png", srgb8_from_linear(test::sphere_photo({200, 150, 150, 150, 100, 75})));
  RecordingContext context({{"photos", photos}});
  Stage stage = ingest_stage();
  stage.options.find("max_side")->assign("120", "test");
  stage.run(context);
  const std::vector<Photo> list = read_photo_list(context.output());
  ASSERT_EQ(list.size(), 21u);
  EXPECT_TRUE(std::ranges::is_sorted(list, {}, &Photo::name));
  EXPECT_EQ(context.metrics.at("panoramas"), 2);
  EXPECT_EQ(list[3].name, "a/view_03.jpg");
  EXPECT_EQ(list[10].name, "b/view_00.png");
  EXPECT_FALSE(list[10].rig);
  EXPECT_EQ(list[11].name, "b_/view_00.png");
  for (size_t i = 0; i < 10; ++i) {
    const Photo& photo = list[i];
    ASSERT_TRUE(photo.rig);
    EXPECT_EQ(photo.rig->panorama, "a.jpg");
    EXPECT_EQ(photo.focal_px, 60);
    const Mat3d rotation = rotation_matrix(photo.rig->rotation);
    EXPECT_LT(length(rotation.c0 - panorama_view_rotation(int(i)).c0), 1e-12);
    // The picture is that of the pinhole camera, in linear light.
    const ImageF seen = read_exr_rgb(ingested_linear_path(context.output(), photo));
    const ImageF expected = test::sphere_photo({120, 120, 60, 60, 60, 60}, rotation);
    ASSERT_EQ(seen.width(), 120);
    double mean = 0;
    for (size_t k = 0; k < seen.data().size(); ++k)
      mean += std::abs(seen.data()[k] - expected.data()[k]) / double(seen.data().size());
    EXPECT_LT(mean, 0.01) << i;
    EXPECT_EQ(read_srgb8(ingested_ldr_path(context.output(), photo)).width(), 120);
  }
}

TEST(PanoramaPhotos, ARotationThatIsNoneIsRefused) {
  const TemporaryFolder folder;
  Photo photo;
  photo.name = "a/view_00.png", photo.stem = "a/view_00", photo.source = "a.png";
  photo.width = 8, photo.height = 8, photo.original_width = 8, photo.original_height = 4;
  photo.rig = PhotoRig{"a.png", {0.5, 0.5, 0.5, 0.5}};
  write_photo_list(folder.path(), {photo});
  EXPECT_EQ(read_photo_list(folder.path())[0], photo);
  photo.rig->rotation.w = 2;
  write_photo_list(folder.path(), {photo});
  EXPECT_THROW(read_photo_list(folder.path()), Error);
}

}  // namespace
}  // namespace vitrine
