#include "stages/ingest/ingest.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/rng.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/probe.h"
#include "core/foundation/math/color.h"
#include "core/intake/photos/exif.h"
#include "core/intake/photos/photo_files.h"
#include "stages/ingest/develop.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

using test::blocks;
using test::RecordingContext;

// Difference of the linear image to the 8-bit picture it should be, in 8-bit steps.
struct Steps {
  double largest = 0, mean = 0;
};
Steps steps_off(const ImageF& linear, const Image8& expected) {
  if (linear.width() != expected.width() || linear.height() != expected.height()) return {1e9, 1e9};
  const Image8 seen = srgb8_from_linear(linear);
  Steps steps;
  for (size_t i = 0; i < seen.data().size(); ++i) {
    const double step = std::abs(double(seen.data()[i]) - expected.data()[i]);
    steps.largest = std::max(steps.largest, step);
    steps.mean += step / static_cast<double>(seen.data().size());
  }
  return steps;
}

void run_ingest(RecordingContext& context, const std::string& max_side = "1600") {
  Stage stage = ingest_stage();
  stage.options.find("max_side")->assign(max_side, "test");
  stage.run(context);
}

// Something for every pixel: a gradient with a little noise.
Image8 picture(int w, int h, uint64_t seed = 1) {
  Rng rng(seed);
  Image8 image(w, h, 3);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<uint8_t>(40 + (x * (c + 1) + y * 2) % 150 + rng.below(20));
  return image;
}

void write_every_format(const fs::path& folder) {
  const Image8 image = picture(40, 30);
  ImageF linear(40, 30, 3);
  Image16 deep(40, 30, 3);
  for (size_t i = 0; i < linear.data().size(); ++i) {
    linear.data()[i] = linear_from_srgb(image.data()[i] / 255.0f);
    deep.data()[i] = static_cast<uint16_t>(image.data()[i] * 257);
  }
  make_folders(folder);
  write_ldr(folder / "a.jpg", image, 98);
  write_ldr(folder / "b.png", image);
  write_file(folder / "c.tif", test::tiff_bytes(image, 1));
  write_exr_rgb(folder / "d.exr", linear, ExrPrecision::Float);
  write_png16(folder / "e.png", deep);
}

TEST(Upright, ShowsAllEightOrientationsOfJpegAndTiff) {
  TemporaryFolder folder;
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const Image8 stored = test::stored_as(blocks(), orientation);
    const fs::path jpeg = folder.path() / (std::to_string(orientation) + ".jpg");
    write_ldr(jpeg, stored, 100);
    test::add_exif(jpeg, test::exif_bytes({{0x0112, 's', static_cast<unsigned>(orientation)}}, {}, orientation % 2 == 0));
    // JPEG blurs colour across the borders of the blocks (worst seen 2.8); a wrong orientation gives more than 40.
    EXPECT_LE(steps_off(ingest::develop(jpeg, 0).linear, blocks()).mean, 8) << "JPEG " << orientation;
    for (unsigned bits : {8u, 16u}) {
      const fs::path tiff = folder.path() / (std::to_string(orientation) + ".tif");
      write_file(tiff, test::tiff_bytes(stored, static_cast<unsigned>(orientation), bits));
      EXPECT_EQ(steps_off(ingest::develop(tiff, 0).linear, blocks()).largest, 0) << "TIFF of " << bits << " bits " << orientation;
    }
  }
}

TEST(Exif, GivesFocalExposureCameraAndTimeInBothByteOrders) {
  for (bool big_endian : {false, true}) {
    const std::string block =
        test::exif_bytes({{0x010f, 'a', 0, 1, "Maker"}, {0x0110, 'a', 0, 1, "Maker X100 "}, {0x0112, 's', 6}},
                         {{0x829a, 'r', 1, 125},
                          {0x829d, 'r', 56, 10},
                          {0x8827, 's', 400},
                          {0x9003, 'a', 0, 1, "2024:05:06 07:08:09"},
                          {0x9209, 's', 9},  // fired, compulsory
                          {0x920a, 'r', 350, 10},
                          {0xa405, 's', 50}},
                         big_endian);
    const Exif exif = parse_exif(block);
    EXPECT_EQ(exif.orientation, 6);
    EXPECT_TRUE(exif.flash);
    EXPECT_EQ(exif.camera, "Maker X100");
    EXPECT_EQ(exif.time, "2024:05:06 07:08:09");
    EXPECT_DOUBLE_EQ(exif.focal_mm.value(), 35);
    EXPECT_NEAR(exposure_ev(exif).value(), std::log2(5.6 * 5.6 * 125) - 2, 1e-12);
    // 50 mm on 36 x 24 mm at 3600 x 2400 pixels: 100 pixels per mm.
    EXPECT_NEAR(focal_of(exif, 3600, 2400)->px, 5000, 1e-3);
    EXPECT_NEAR(focal_of(exif, 1200, 1800)->px, 2500, 1e-3);
  }
}

TEST(Exif, FocalFromTheFocalPlaneFollowsAResize) {
  // Canon 600D: 18 mm, 5184 pixels on 22.3 mm (5904.3 per inch).
  const std::string block = test::exif_bytes(
      {}, {{0x920a, 'r', 18, 1}, {0xa002, 'l', 5184}, {0xa003, 'l', 3456}, {0xa20e, 'r', 5184000, 878}, {0xa210, 's', 2}});
  const Exif exif = parse_exif(block);
  const double full = 18 * (5184000.0 / 878) / 25.4;
  EXPECT_NEAR(focal_of(exif, 5184, 3456)->px, full, 1e-6);
  EXPECT_NEAR(focal_of(exif, 1000, 667)->px, full * 1000 / 5184, 1) << "667 is rounded up";
  EXPECT_NEAR(focal_of(exif, 1000, 1000)->px, full * 1000 / 3456, 1e-6) << "cropped to a square, then reduced";
  EXPECT_EQ(focal_of(exif, 1000, 667)->source, "exif FocalLength and FocalPlaneXResolution");
}

TEST(Exif, ASensitivityOfMoreThan65535IsInItsOtherFields) {
  const std::vector<test::Tag> shot{{0x829a, 'r', 1, 100}, {0x829d, 'r', 4, 1}, {0x8827, 's', 65535}};
  EXPECT_FALSE(exposure_ev(parse_exif(test::exif_bytes({}, shot))));
  std::vector<test::Tag> full = shot;
  full.push_back({0x8832, 'l', 102400});
  EXPECT_NEAR(exposure_ev(parse_exif(test::exif_bytes({}, full))).value(), std::log2(1600.0 / 1024), 1e-9);
}

TEST(Exif, TheZoomIsTheFocalLengthTimesTheDigitalOne) {
  EXPECT_FALSE(zoom_of(parse_exif(test::exif_bytes({}, {}))));
  EXPECT_DOUBLE_EQ(zoom_of(parse_exif(test::exif_bytes({}, {{0x920a, 'r', 24, 1}}))).value(), 24);
  EXPECT_DOUBLE_EQ(zoom_of(parse_exif(test::exif_bytes({}, {{0x920a, 'r', 24, 1}, {0xa404, 'r', 3, 2}}))).value(), 36);
  EXPECT_DOUBLE_EQ(zoom_of(parse_exif(test::exif_bytes({}, {{0xa404, 'r', 3, 2}}))).value(), 1.5);
}

TEST(Exif, AFlashThatDidNotFireIsNone) {
  EXPECT_FALSE(parse_exif(test::exif_bytes({}, {{0x9209, 's', 16}})).flash);  // off, compulsory
  EXPECT_FALSE(Exif{}.flash);
}

TEST(Exif, NonsenseAndDamageAreNotBelieved) {
  EXPECT_FALSE(focal_of(Exif{}, 100, 100));
  Exif far;
  far.focal_35mm = 65535;
  EXPECT_FALSE(focal_of(far, 1000, 1000));
  const std::string block =
      test::exif_bytes({{0x010f, 'a', 0, 1, "Maker"}, {0x0112, 's', 9}}, {{0x829a, 'r', 1, 0}, {0xa405, 's', 0}});
  EXPECT_EQ(parse_exif(block).orientation, 1);
  EXPECT_FALSE(parse_exif(block).exposure_s);
  EXPECT_FALSE(parse_exif(block).focal_35mm);
  for (size_t i = 0; i < block.size(); ++i) {
    parse_exif(std::string_view(block).substr(0, i));
    std::string damaged = block;
    damaged[i] = static_cast<char>(damaged[i] ^ 0xff);
    const Exif exif = parse_exif(damaged);
    EXPECT_GE(exif.orientation, 1);
    EXPECT_LE(exif.orientation, 8);
  }
}

TEST(Probe, KnowsTheSizeOfEveryFormatAndMissesEnds) {
  TemporaryFolder folder;
  write_every_format(folder.path());
  for (const char* name : {"a.jpg", "b.png", "c.tif", "d.exr", "e.png"}) {
    const std::string bytes = read_file(folder.path() / name);
    const Probe probe = probe_photo(bytes);
    EXPECT_EQ(probe.width, 40u) << name;
    EXPECT_EQ(probe.height, 30u) << name;
    EXPECT_EQ(missing_end(bytes), "") << name;
    for (size_t length = 0; length < bytes.size(); length += 7) probe_photo(std::string_view(bytes).substr(0, length));
  }
  const std::string jpeg = read_file(folder.path() / "a.jpg");
  EXPECT_NE(missing_end(jpeg.substr(0, jpeg.size() - 2)), "");
}

TEST(Ingest, EveryFormatGivesTheSameLinearPicture) {
  TemporaryFolder folder;
  write_every_format(folder.path());
  RecordingContext context({{"photos", folder.path()}});
  run_ingest(context);
  const std::vector<Photo> photos = read_photo_list(context.output());
  ASSERT_EQ(photos.size(), 5u);
  EXPECT_EQ(photos[3].name, "d.png");
  EXPECT_EQ(photos[3].source, "d.exr");
  for (const Photo& photo : photos) {
    const Steps linear = steps_off(read_exr_rgb(ingested_linear_path(context.output(), photo)), picture(40, 30));
    const Steps copy = steps_off(linear_from_srgb_image(read_srgb(ingested_ldr_path(context.output(), photo))), picture(40, 30));
    if (photo.name == "a.jpg") {
      EXPECT_LE(linear.mean, 12);  // JPEG blurs the noise of the colours
      EXPECT_LE(copy.mean, 12);
    } else {
      EXPECT_EQ(linear.largest, 0) << photo.name;
      EXPECT_EQ(copy.largest, 0) << photo.name;
    }
  }
  EXPECT_EQ(context.metrics["photos"], 5);
  EXPECT_EQ(context.metrics["photo_sizes"], 1);
  EXPECT_DOUBLE_EQ(context.fractions.back(), 1);
}

TEST(Ingest, ReducesInLinearLightAndScalesTheFocalLength) {
  TemporaryFolder folder;
  for (const char* name : {"a.jpg", "b.jpg"}) {
    Image8 stripes(80, 60, 3);  // black and white columns: linear mean 0.5, not sRGB mean
    for (int y = 0; y < 60; ++y)
      for (int x = 0; x < 80; ++x)
        for (int c = 0; c < 3; ++c) stripes.at(x, y, c) = x % 2 ? 255 : 0;
    write_ldr(folder.path() / name, stripes, 100);
    test::add_exif(folder.path() / name, test::exif_bytes({}, {{0xa405, 's', 36}}));
  }
  RecordingContext context({{"photos", folder.path()}});
  run_ingest(context, "40");
  const Photo photo = read_photo_list(context.output()).at(0);
  EXPECT_EQ(photo.width, 40);
  EXPECT_EQ(photo.height, 30);
  EXPECT_EQ(photo.original_width, 80);
  EXPECT_NEAR(photo.focal_px.value(), 36 * 50 / 43.2666153, 1e-6);
  EXPECT_NEAR(read_exr_rgb(ingested_linear_path(context.output(), photo)).at(20, 15, 1), 0.5, 0.02);
}

TEST(Ingest, ReducesATallPhotoWhoseWidthStays) {
  TemporaryFolder folder;
  for (const char* name : {"a.png", "b.png"}) write_ldr(folder.path() / name, picture(30, 81));
  RecordingContext context({{"photos", folder.path()}});
  run_ingest(context, "80");  // 29.6 is 30, too
  const Photo photo = read_photo_list(context.output()).at(0);
  const ImageF linear = read_exr_rgb(ingested_linear_path(context.output(), photo));
  EXPECT_EQ(photo.width, 30);
  EXPECT_EQ(photo.height, 80);
  EXPECT_EQ(linear.width(), 30);
  EXPECT_EQ(linear.height(), 80);
}

TEST(PhotoNames, AreValidUtf8) {
  const std::pair<const char*, const char*> names[] = {{"\xf0\x9f\x98\x80.png", "\xf0\x9f\x98\x80.png"},
                                                       {"\xe0\xa4\x85.png", "\xe0\xa4\x85.png"},
                                                       {"\xed\x9f\xbf.png", "\xed\x9f\xbf.png"},
                                                       {"\xf4\x8f\xbf\xbf.png", "\xf4\x8f\xbf\xbf.png"},
                                                       {"\xc0\xaf.png", "__.png"},
                                                       {"\xe0\x80\xaf.png", "___.png"},  // overlong slashes
                                                       {"\xf0\x80\x80\xaf.png", "____.png"},
                                                       {"\xed\xa0\x80.png", "___.png"},  // half of a pair
                                                       {"\xf4\x90\x80\x80.png", "____.png"},
                                                       {"\xe2\x82.png", "__.png"},  // cut off
                                                       {"a\x01"
                                                        "b\x7f.png",
                                                        "a_b_.png"}};
  for (const auto& [source, name] : names) {
    std::vector<PhotoFile> photos(1);
    photos[0].source = source;
    assign_names(photos);
    EXPECT_EQ(photos[0].name, name);
  }
}

TEST(Ingest, KeepsSubFoldersAndStrangeNamesAndSeparatesTwins) {
  TemporaryFolder parent;
  const fs::path folder = parent.path() /
                          "m\xc3\xb6"
                          "bel \xe5\x86\x99\xe7\x9c\x9f";
  for (const char* name : {"left/a.jpg", "left/a.png", "left/A.JPG", "right/a.jpg",
                           "gr\xc3\xbc\xc3\x9f"
                           "e 1.PNG",
                           "z\xff.png"}) {
    make_folders((folder / name).parent_path());
    const fs::path plain = folder / "plain.png";
    write_ldr(plain, picture(16, 12));
    fs::rename(plain, folder / name);  // content decides, not the extension
  }
  write_file(folder / ".hidden.jpg", "x");
  write_file(folder / ".thumbnails/a.jpg", "x");
  write_file(folder / "notes.txt", "x");
  write_file(folder / "moving.GIF", "x");
  RecordingContext context({{"photos", folder}});
  run_ingest(context);
  const std::vector<Photo> photos = read_photo_list(context.output());
  std::vector<std::string> names;
  for (const Photo& photo : photos) {
    names.push_back(photo.name);
    EXPECT_EQ(fs::path(photo.name).replace_extension().generic_string(), photo.stem);
    EXPECT_TRUE(fs::exists(ingested_linear_path(context.output(), photo))) << photo.stem;
    EXPECT_TRUE(fs::exists(ingested_ldr_path(context.output(), photo))) << photo.stem;
  }
  EXPECT_EQ(names, (std::vector<std::string>{"gr\xc3\xbc\xc3\x9f"
                                             "e 1.PNG",
                                             "left/A.JPG", "left/a.jpg", "left/a_png.png", "right/a.jpg", "z_.png"}));
  EXPECT_EQ(context.metrics["files_skipped"], 4);
  EXPECT_NE(context.warnings["PHOTO_TYPES_NOT_READ"].find(".gif"), std::string::npos);
}

TEST(Ingest, LeavesBadPhotosOutAndSaysWhy) {
  TemporaryFolder folder;
  for (int i = 0; i < 3; ++i) write_ldr(folder.path() / ("good" + std::to_string(i) + ".jpg"), picture(32 + 8 * (i == 2), 24));
  const std::string jpeg = read_file(folder.path() / "good0.jpg");
  write_ldr(folder.path() / "x.png", picture(32, 24));
  const std::string png = read_file(folder.path() / "x.png"), tiff = test::tiff_bytes(picture(32, 24), 1);
  write_file(folder.path() / "bad_empty.jpg", "");
  write_file(folder.path() / "bad_half.jpg", jpeg.substr(0, jpeg.size() / 2));
  write_file(folder.path() / "bad_half.png", png.substr(0, png.size() / 2));
  write_file(folder.path() / "bad_half.tif", tiff.substr(0, tiff.size() / 2));
  write_file(folder.path() / "bad_text.jpg", "this is no photo");
  write_file(folder.path() / "bad_exr.exr", std::string("\x76\x2f\x31\x01", 4) + "junk");
  RecordingContext context({{"photos", folder.path()}});
  run_ingest(context);
  EXPECT_EQ(read_photo_list(context.output()).size(), 4u);
  EXPECT_EQ(context.metrics["photos_left_out"], 6);
  for (const char* name : {"bad_empty.jpg", "bad_half.jpg", "bad_half.png", "bad_half.tif", "bad_text.jpg", "bad_exr.exr"})
    EXPECT_NE(context.warnings["PHOTOS_LEFT_OUT"].find(name), std::string::npos) << name;
  EXPECT_TRUE(context.warnings.contains("PHOTO_SIZES_DIFFER"));
}

TEST(Ingest, DamagedPhotosNeverCrash) {
  TemporaryFolder folder;
  write_every_format(folder.path());
  test::add_exif(folder.path() / "a.jpg", test::exif_bytes({{0x0112, 's', 6}}, {{0xa405, 's', 36}}));
  for (const char* name : {"a.jpg", "b.png", "c.tif", "d.exr"}) {
    const fs::path path = folder.path() / name;
    const std::string whole = read_file(path);
    const size_t stride = whole.size() / 60 + 1;
    for (size_t i = 0; i < whole.size(); i += stride) {
      for (const std::string& bytes :
           {whole.substr(0, i), whole.substr(0, i) + static_cast<char>(whole[i] ^ 0x7f) + whole.substr(i + 1)}) {
        fs::remove(path);  // truncating would make some file systems wait for the disk
        std::ofstream(path, std::ios::binary) << bytes;
        try {
          ingest::develop(path, 64);
        } catch (const Error& e) {
          EXPECT_EQ(e.kind(), ErrorKind::Input) << name << " " << i << " " << e.what();
        }
      }
    }
  }
}

TEST(Ingest, SaysWhatItLeavesOutAndWhatIsThereTwice) {
  TemporaryFolder folder;
  const fs::path other = folder.path() / "other", photos = folder.path() / "photos";
  make_folders(photos);
  make_folders(other);
  for (int i = 0; i < 3; ++i) write_ldr(photos / fmt::format("{}.jpg", i), picture(64, 48, uint64_t(i)));
  write_file(photos / "0 copy.jpg", read_file(photos / "0.jpg"));
  Image8 mask(64, 48, 1);
  for (int x = 20; x < 40; ++x) mask.at(x, 20) = 255;
  write_ldr(photos / "1_mask.png", mask);
  write_ldr(other / "b.jpg", picture(64, 48, 9));
  fs::create_directory_symlink(other, photos / "day2");
  RecordingContext context({{"photos", photos}});
  run_ingest(context);
  EXPECT_EQ(context.metrics["photos"], 5);
  EXPECT_EQ(context.metrics["files_beside_photos"], 1);
  EXPECT_EQ(context.warnings["PHOTOS_REPEATED"],
            "1 photo is the same file as another (0.jpg is 0 copy.jpg): 4 different photos remain");
  EXPECT_NE(context.warnings["MASKS_BESIDE_PHOTOS"].find("1 file is a mask of another file (1_mask.png of 1.jpg)"),
            std::string::npos);
  const std::vector<Photo> list = read_photo_list(context.output());
  EXPECT_EQ(list.back().name, "day2/b.jpg");
}

TEST(Ingest, RefusesFoldersWithoutEnoughPhotos) {
  TemporaryFolder folder;
  const auto run_on = [&](const fs::path& path) {
    return error_of([&] {
      RecordingContext context({{"photos", path}});
      run_ingest(context);
    });
  };
  EXPECT_EQ(run_on(folder.path() / "none").kind(), ErrorKind::Input);
  write_file(folder.path() / "a.txt", "x");
  const Error empty = run_on(folder.path());
  EXPECT_EQ(empty.detail().code, "NO_PHOTOS");
  EXPECT_NE(empty.detail().why.find(".tiff"), std::string::npos);
  EXPECT_NE(empty.detail().why.find("1 x .txt"), std::string::npos);
  write_ldr(folder.path() / "one.png", picture(16, 12));
  write_file(folder.path() / "two.jpg", "");
  const Error few = run_on(folder.path());
  EXPECT_EQ(few.detail().code, "TOO_FEW_PHOTOS");
  EXPECT_NE(few.detail().why.find("two.jpg"), std::string::npos);
  EXPECT_EQ(run_on(folder.path() / "a.txt").kind(), ErrorKind::Input);
}

TEST(Ingest, GivesTheSameBytesForAnyThreadCountAndMemoryLimit) {
  TemporaryFolder folder;
  for (int i = 0; i < 7; ++i) write_ldr(folder.path() / (std::to_string(i) + ".jpg"), picture(64, 48, static_cast<uint64_t>(i)));
  std::vector<Digest> digests;
  for (int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    RecordingContext context({{"photos", folder.path()}});
    context.max_memory = threads == 8 ? 1 : 0;
    run_ingest(context, "50");
    digests.push_back(digest_folder(context.output()));
  }
  set_thread_limit(0);
  EXPECT_EQ(digests[0], digests[1]);
  EXPECT_EQ(digests[0], digests[2]);
}

}  // namespace
}  // namespace vitrine
