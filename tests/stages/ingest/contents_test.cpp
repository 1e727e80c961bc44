// What is said of photos whose files hold something else, or more, than their name says.
#include <gtest/gtest.h>

#include "core/intake/photos/photo_list.h"
#include "core/scene/image/exr.h"
#include "core/intake/photos/photo_files.h"
#include "stages/ingest/develop.h"
#include "stages/ingest/ingest.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiff_file.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

TEST(Contents, PicturesAreTakenWholeAndWhatIsLeftOutIsSaidOnce) {
  TemporaryFolder folder;
  for (const char* name : {"a.jpg", "b.jpg"}) {
    write_ldr(folder.path() / name, test::blocks());
    write_file(folder.path() / name,
               read_file(folder.path() / name) + std::string("\0\0\0\x18", 4) + "ftypmp42" + std::string(300'000, 'x'));
  }
  for (const char* name : {"c.tif", "d.tif"})
    test::write_tiff(folder.path() / name, {.samples = 5, .planar = true, .extra = {0, 0}}, 48, 32);
  write_exr(folder.path() / "e.exr", {.pixels = ImageF(48, 32, 4, 0.25f),
                                      .channels = {"V.Combined.R", "V.Combined.G", "V.Combined.B", "V.Depth.Z"},
                                      .attributes = {}});
  ImageF bright(48, 32, 3, 0.5f);
  bright.at(3, 4, 0) = INFINITY, bright.at(5, 6, 1) = -0.5f, bright.at(7, 8, 2) = NAN;
  write_exr_rgb(folder.path() / "f.exr", bright, ExrPrecision::Float);
  write_file(folder.path() / "g.jpg", std::string("\0\0\0\x18"
                                                  "ftypheic\0\0\0\0mif1heic",
                                                  24));
  write_file(folder.path() / "h.jpg", "<!DOCTYPE html><html></html>");
  test::RecordingContext context({{"photos", folder.path()}});
  ingest_stage().run(context);
  const std::vector<Photo> photos = read_photo_list(context.output());
  ASSERT_EQ(photos.size(), 6u);
  EXPECT_NEAR(read_exr_rgb(ingested_linear_path(context.output(), photos[4])).at(9, 9, 2), 0.25f, 1e-3);
  const ImageF repaired = read_exr_rgb(ingested_linear_path(context.output(), photos[5]));
  EXPECT_EQ(repaired.at(3, 4, 0), 65504.f);
  EXPECT_EQ(repaired.at(5, 6, 1), -0.5f) << "as colours outside of Rec. 709 have it";
  EXPECT_EQ(repaired.at(7, 8, 2), 0.f);
  EXPECT_NE(context.warnings["PIXELS_NOT_FINITE"].find("1 values that are not numbers were set to 0, 1 above 65504"),
            std::string::npos);
  EXPECT_NE(context.warnings["PHOTO_CONTENT"].find("2 photos (c.tif and others): a TIFF of 5 channels"), std::string::npos)
      << context.warnings["PHOTO_CONTENT"];
  EXPECT_NE(context.warnings["PHOTOS_LEFT_OUT"].find("g.jpg: it is a HEIC photo without a picture: the copy was cut short"), std::string::npos);
  EXPECT_NE(context.warnings["PHOTOS_LEFT_OUT"].find("h.jpg: it is a web page"), std::string::npos);
}

TEST(Contents, TheOrientationOfATiffIsAppliedOnce) {
  TemporaryFolder folder;
  for (unsigned orientation = 1; orientation <= 8; ++orientation) {
    const fs::path path = folder.path() / "a.tif";
    write_file(path, test::tiff_bytes(test::stored_as(test::blocks(), int(orientation)), orientation));
    const ingest::Developed d = ingest::develop(path, 0);
    EXPECT_EQ(d.photo.orientation, int(orientation));
    EXPECT_EQ(srgb8_from_linear(d.linear), test::blocks()) << orientation;
    EXPECT_EQ(srgb8_from_linear(linear_from_srgb_image(read_as_oriented(path))), test::blocks()) << orientation;
  }
}

// The fields of a TIFF stand behind its pixels, further away than libexif looks, and BigTIFF it does not know.
TEST(Contents, ExifOfATiffIsFoundWhereverItStands) {
  TemporaryFolder folder;
  for (const bool big : {false, true})
    for (const bool big_endian : {false, true}) {
      const fs::path path = folder.path() / "a.tif";
      TIFF* const tiff = test::open_tiff(path, {.big = big, .big_endian = big_endian});
      uint64_t place = 0;
      TIFFSetField(tiff, TIFFTAG_MAKE, "Maker");
      TIFFSetField(tiff, TIFFTAG_MODEL, "Model 5");
      TIFFSetField(tiff, TIFFTAG_EXIFIFD, place);
      test::add_tiff_page(tiff, 300, 200, {});
      TIFFCreateEXIFDirectory(tiff);
      TIFFSetField(tiff, EXIFTAG_FOCALLENGTHIN35MMFILM, 35);
      TIFFSetField(tiff, EXIFTAG_EXPOSURETIME, 0.01);
      TIFFWriteCustomDirectory(tiff, &place);
      TIFFSetDirectory(tiff, 0);
      TIFFSetField(tiff, TIFFTAG_EXIFIFD, place);
      TIFFRewriteDirectory(tiff);
      TIFFClose(tiff);
      const PhotoHead head = read_photo_head(path);
      EXPECT_EQ(head.probe.width, 300u) << big << big_endian;
      EXPECT_EQ(head.exif.camera, "Maker Model 5") << big << big_endian;
      ASSERT_TRUE(head.exif.focal_35mm) << big << big_endian;
      EXPECT_EQ(*head.exif.focal_35mm, 35);
      EXPECT_NEAR(head.exif.exposure_s.value_or(0), 0.01, 1e-4);
    }
}

}  // namespace
}  // namespace vitrine
