// Raw photos through ingest: known sensor samples come back as the linear colours of the scene.
#ifdef VITRINE_WITH_LIBRAW

#include <gtest/gtest.h>

#include <cmath>

#include "core/intake/photos/linear_photo.h"
#include "core/intake/photos/photo_files.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/resample.h"
#include "stages/ingest/develop.h"
#include "stages/ingest/ingest.h"
#include "tests/support/dng_file.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

using ingest::develop;
using test::dng_bytes;
using test::DngDesc;

constexpr int kPatch = 32;  // pixels
constexpr Vec3d kPatches[] = {{0.5, 0.5, 0.5}, {0.6, 0.3, 0.1},    {0.1, 0.2, 0.6},
                              {0.2, 0.5, 0.2}, {0.05, 0.05, 0.05}, {0.7, 0.6, 0.2}};

Vec3d patches(int x, int y) { return kPatches[size_t(x / kPatch + 3 * (y / kPatch))]; }

void expect_colour(const ImageF& linear, int x, int y, const Vec3d& expected, const char* text) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(linear.at(x, y, c), expected[size_t(c)], 0.003 + 0.005 * expected[size_t(c)])
        << text << " " << x << " " << y << " " << c;
}

class RawPhotos : public testing::Test {
 protected:
  fs::path written(const std::string& name, const std::string& bytes) {
    write_file(folder.path() / name, bytes);
    return folder.path() / name;
  }
  TemporaryFolder folder;
};

TEST_F(RawPhotos, SamplesOfTheSensorBecomeLinearColours) {
  for (const char* name : {"a.dng", "called.tif"}) {
    const ingest::Developed d = develop(written(name, dng_bytes({}, patches)), 0);
    ASSERT_EQ(d.linear.width(), 96);
    ASSERT_EQ(d.linear.height(), 64);
    for (int k = 0; k < 6; ++k)
      expect_colour(d.linear, kPatch / 2 + kPatch * (k % 3), kPatch / 2 + kPatch * (k / 3), kPatches[k], name);
    EXPECT_EQ(d.photo.color_profile, "linear Rec. 709");
    EXPECT_EQ(d.photo.color_source, "camera raw");
    EXPECT_EQ(d.photo.camera, "Maker Model R");
    EXPECT_NEAR(d.photo.focal_px.value_or(0), 40 * std::hypot(96, 64) / 43.2666, 0.1);
    EXPECT_NEAR(d.photo.exposure_ev.value_or(0), std::log2(2.0 * 2.0 / 0.01), 1e-3);
  }
}

TEST_F(RawPhotos, BrightnessIsThatOfTheSensorInEveryPhoto) {
  const auto grey = [&](double level) {
    return develop(written("a.dng", dng_bytes({}, [&](int, int) { return Vec3d{level, level, level}; })), 0).linear;
  };
  for (const double level : {0.01, 0.1, 0.8}) expect_colour(grey(level), 48, 32, {level, level, level}, "level");
}

TEST_F(RawPhotos, SaturatedPixelsStayNeutralAndBrightOnesAreKept) {
  double last = 0;
  for (const double level : {0.9, 1.1, 1.2, 1.35, 2.0, 9.0}) {
    const ImageF linear = develop(written("a.dng", dng_bytes({},
                                                             [&](int x, int) {
                                                               return x < 48 ? Vec3d{level, level, level} : Vec3d{0.2, 0.2, 0.2};
                                                             })),
                                  0)
                              .linear;
    const float* const p = linear.pixel(20, 32);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(p[c] / p[1], 1, 0.02) << level;
    EXPECT_GE(p[1], last - 0.01) << "brighter light is no darker";
    if (level < 1.3) {
      EXPECT_NEAR(p[1], level, 0.02 * level) << "above 1, from the channels that do not saturate";
    }
    last = p[1];
  }
  EXPECT_GT(last, 1.3);
  const Vec3d red{1.2, 0.2, 0.2};  // one channel above 1 is kept as well
  expect_colour(develop(written("a.dng", dng_bytes({}, [&](int, int) { return red; })), 0).linear, 48, 32, red, "red");
}

TEST_F(RawPhotos, OrientationIsAppliedOnce) {
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const fs::path path = written("a.dng", dng_bytes({.orientation = orientation}, patches));
    const ingest::Developed d = develop(path, 0);
    ImageF expected(96, 64, 3);
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 96; ++x)
        for (int c = 0; c < 3; ++c) expected.at(x, y, c) = float(patches(x, y)[size_t(c)]);
    expected = upright(expected, orientation);
    ASSERT_EQ(d.linear.width(), expected.width()) << orientation;
    EXPECT_EQ(d.photo.orientation, orientation);
    const int step = kPatch / 2;
    for (int y = step; y < expected.height(); y += kPatch)
      for (int x = step; x < expected.width(); x += kPatch)
        expect_colour(d.linear, x, y, {expected.at(x, y, 0), expected.at(x, y, 1), expected.at(x, y, 2)}, "turned");
    EXPECT_EQ(upright_size(read_photo_head(path)).width, expected.width());
  }
}

// The camera measures white balance anew for each photo; a folder has that of its first photo.
TEST_F(RawPhotos, TheWhiteBalanceOfTheFirstPhotoIsThatOfAll) {
  const auto grey = [](int, int) { return Vec3d{0.4, 0.4, 0.4}; };
  const Vec3d lit = test::dng_neutral(), warm{0.7 * lit.x, lit.y, 1.4 * lit.z};
  written("a.dng", dng_bytes({}, grey));
  written("b.dng", dng_bytes({.neutral = warm}, grey));
  written("c.dng", dng_bytes({.model = "Other", .neutral = warm}, grey));
  written("d.dng", dng_bytes({.model = "Other"}, grey));
  test::RecordingContext context({{"photos", folder.path()}});
  ingest_stage().run(context);
  const std::vector<Photo> photos = read_photo_list(context.output());
  ASSERT_EQ(photos.size(), 4u);
  const auto ratio = [&](size_t i) {
    const ImageF linear = read_exr_rgb(ingested_linear_path(context.output(), photos[i]));
    return double(linear.at(48, 32, 2)) / double(linear.at(48, 32, 0));
  };
  EXPECT_NEAR(ratio(0), 1, 0.01);
  EXPECT_NEAR(ratio(1), 1, 0.01);
  EXPECT_GT(std::abs(std::log(ratio(2))), 0.2) << "another camera has a first photo of its own";
  EXPECT_NEAR(ratio(3), ratio(2), 0.01);
  const ImageF alone = develop(folder.path() / "b.dng", 0).linear;
  EXPECT_GT(std::abs(std::log(double(alone.at(48, 32, 2)) / double(alone.at(48, 32, 0)))), 0.2);
  EXPECT_EQ(photos[0].name, "a.png");
}

TEST_F(RawPhotos, APreviewIsOfHalfSize) {
  const fs::path path = written("a.dng", dng_bytes({}, patches));
  const Image8 small = reduced_photo(path, read_photo_head(path), 48);
  EXPECT_EQ(small.width(), 48);
  EXPECT_NEAR(small.at(8, 8, 0), 188, 2);  // 0.5 in sRGB
}

TEST_F(RawPhotos, WhatCannotBeDevelopedIsNamedWithItsCamera) {
  const auto why = [&](const std::string& bytes) {
    return error_of([&, path = written("a.dng", bytes)] { develop(path, 0); }).detail().why;
  };
  const std::string good = dng_bytes({}, patches);
  const std::string unknown = why(dng_bytes({.matrix = false}, patches));
  EXPECT_NE(unknown.find("does not know the colours of its camera (Maker Model R): export a 16-bit TIFF, or a DNG"),
            std::string::npos)
      << unknown;
  EXPECT_NE(why(good.substr(0, 4000)), "");
  // Cameras write the samples behind the directory: a copy that was cut short lacks the end of them.
  constexpr size_t kSamplesAt = 8, kSampleBytes = size_t(96) * 64 * 2;
  const std::string_view place("\x11\x01\x04\0\1\0\0\0\x08\0\0\0", 12);  // StripOffsets
  std::string last = good + good.substr(kSamplesAt, kSampleBytes);
  const size_t at = last.find(place);
  ASSERT_NE(at, std::string::npos);
  for (size_t i = 0; i < 4; ++i) last[at + 8 + i] = static_cast<char>(good.size() >> (8 * i));
  EXPECT_EQ(develop(written("b.dng", last), 0).linear.width(), 96);
  for (const size_t lost : {size_t(100), kSampleBytes / 2}) {
    const std::string text = why(last.substr(0, last.size() - lost));
    EXPECT_NE(text.find("cut short; copy it again"), std::string::npos) << lost << ": " << text;
  }
  EXPECT_NE(why("FUJIFILMCCD-RAW 0201" + std::string(2000, 'x')).find("LibRaw"), std::string::npos);
}

TEST_F(RawPhotos, OneFileOfEachPhotoIsUsed) {
  const auto grey = [](int, int) { return Vec3d{0.4, 0.4, 0.4}; };
  const auto jpeg = [&](const char* name, const char* time) {
    write_ldr(folder.path() / name, Image8(96, 64, 3, 90));
    test::add_exif(folder.path() / name, test::exif_bytes({}, {{0x9003, 'a', 0, 0, time}}));
  };
  const char* const time = "2026:05:01 10:00:00";
  for (const char* stem : {"a", "b", "c", "d"}) written(std::string(stem) + ".DNG", dng_bytes({.time = time}, grey));
  jpeg("a.JPG", time);
  jpeg("b.jpg", time);
  jpeg("c.jpg", "2026:05:02 11:00:00");  // of another camera, by chance of the same number
  write_png16(folder.path() / "d.png", [] {
    Image16 developed(96, 64, 3);
    for (size_t i = 0; i < developed.data().size(); ++i) developed.data()[i] = static_cast<uint16_t>(i * 7919);
    return developed;
  }());
  const PhotoFolder found = find_photos(folder.path());
  std::vector<std::string> sources;
  for (const PhotoFile& photo : found.photos) sources.push_back(photo.source);
  EXPECT_EQ(sources, (std::vector<std::string>{"a.DNG", "b.DNG", "c.DNG", "c.jpg", "d.png"}));
  bool noted = false;
  for (const FolderNote& note : notes_of(found)) {
    if (note.code != "PHOTOS_IN_TWO_FORMATS") continue;
    noted = true;
    EXPECT_NE(note.sentence().find("a.JPG is left out for a.DNG"), std::string::npos) << note.sentence();
  }
  EXPECT_TRUE(noted);
  // Raw files that cannot be developed give way.
  for (const char* stem : {"a", "b", "c", "d"})
    written(std::string(stem) + ".DNG", dng_bytes({.time = time, .matrix = false}, grey));
  EXPECT_EQ(find_photos(folder.path()).photos[0].source, "a.JPG");
}

}  // namespace
}  // namespace vitrine

#endif
