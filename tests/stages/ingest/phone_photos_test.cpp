// HEIC and AVIF photos through ingest: colours, bits, orientation, EXIF, and what is refused.
#ifdef VITRINE_WITH_LIBHEIF

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/foundation/math/color.h"
#include "core/intake/photos/linear_photo.h"
#include "core/intake/photos/photo_files.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/heif_file.h"
#include "core/scene/image/resample.h"
#include "stages/ingest/develop.h"
#include "stages/ingest/ingest.h"
#include "tests/stages/ingest/tagged_photos.h"
#include "tests/support/error_of.h"
#include "tests/support/heif_writer.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using ingest::develop;
using ingest::Developed;
using test::heif_bytes;
using test::HeifDesc;

// Smooth in both directions, all channels different; no symmetry.
Image8 phone_picture(int width = 96, int height = 64) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      image.at(x, y, 0) = static_cast<uint8_t>(30 + 180 * x / width);
      image.at(x, y, 1) = static_cast<uint8_t>(40 + 150 * y / height);
      image.at(x, y, 2) = static_cast<uint8_t>(60 + 60 * x / width + 60 * (height - y) / height);
    }
  return image;
}

// Largest difference in steps of 8 bits.
double largest_step(const ImageF& linear, const Image8& expected) {
  if (linear.width() != expected.width() || linear.height() != expected.height()) return 1e9;
  const Image8 seen = srgb8_from_linear(linear);
  double largest = 0;
  for (size_t i = 0; i < seen.data().size(); ++i)
    largest = std::max(largest, std::abs(double(seen.data()[i]) - expected.data()[i]));
  return largest;
}

class PhonePhotos : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::heif_encodes(heif_compression_HEVC)) GTEST_SKIP() << "libheif has no encoder of HEVC: libheif-plugin-x265";
  }
  fs::path written(const std::string& name, const std::string& bytes) {
    write_file(folder.path() / name, bytes);
    return folder.path() / name;
  }
  std::string why(const std::string& bytes) {
    const fs::path path = written("bad.heic", bytes);
    return error_of([&] { develop(path, 0); }).detail().why;
  }
  TemporaryFolder folder;
};

constexpr double kSteps = 2;  // of YCbCr in 8 bits and back

TEST_F(PhonePhotos, HeicAndAvifHaveThePicture) {
  for (const auto format : {heif_compression_HEVC, heif_compression_AV1}) {
    if (!test::heif_encodes(format)) continue;
    const Developed d = develop(written("a.heic", heif_bytes(phone_picture(), {.format = format})), 0);
    EXPECT_LE(largest_step(d.linear, phone_picture()), kSteps) << format;
    EXPECT_EQ(d.photo.color_profile, "sRGB");
    EXPECT_EQ(d.photo.color_source, "heif nclx");
  }
}

TEST_F(PhonePhotos, TheContentDecidesWhateverTheName) {
  EXPECT_LE(largest_step(develop(written("called.jpg", heif_bytes(phone_picture(), {})), 0).linear, phone_picture()), kSteps);
}

TEST_F(PhonePhotos, TheBoxesTurnThePictureAndExifDoesNotTurnItAgain) {
  for (const int orientation : {1, 3, 6, 8}) {
    const std::string exif = test::exif_bytes({{0x0112, 's', static_cast<unsigned>(orientation)}}, {}).substr(6);
    const fs::path path = written("a.heic", heif_bytes(phone_picture(), {.orientation = orientation, .exif = exif}));
    const Developed d = develop(path, 0);
    const Image8 expected = bytes_of(upright(floats_of(phone_picture()), orientation));
    EXPECT_LE(largest_step(d.linear, expected), kSteps) << orientation;
    EXPECT_EQ(d.photo.orientation, 1);
    const PhotoHead head = read_photo_head(path);
    EXPECT_EQ(upright_size(head).width, expected.width()) << "known without decoding, " << orientation;
    EXPECT_EQ(upright_size(head).height, expected.height());
    EXPECT_LE(largest_step(linear_from_srgb_image(floats_of(upright_photo(path, head, 1000))), expected), kSteps + 1)
        << "preview";
  }
}

TEST_F(PhonePhotos, CodePointsAndProfilesAreConverted) {
  const std::string icc = test::icc_bytes(test::display_p3());
  const Developed by_points = develop(written("a.heic", heif_bytes(phone_picture(), {.primaries = 12})), 0);
  const Developed by_icc = develop(written("b.heic", heif_bytes(phone_picture(), {.icc = icc})), 0);
  EXPECT_EQ(by_points.photo.color_profile, "Display P3");
  EXPECT_EQ(by_points.photo.color_source, "heif nclx");
  EXPECT_EQ(by_icc.photo.color_profile, "Display P3");
  EXPECT_EQ(by_icc.photo.color_source, "icc");
  ImageF expected = floats_of(phone_picture());
  primaries_profile("P3", kDisplayP3, [](double v) { return linear_from_srgb(v); })->to_linear(expected);
  const auto largest = [&](const ImageF& linear) {
    double off = 0;
    for (size_t i = 0; i < linear.data().size(); ++i)
      off = std::max(off, std::abs(double(linear.data()[i] - expected.data()[i])));
    return off;
  };
  ASSERT_GT(largest(linear_from_srgb_image(floats_of(phone_picture()))), 0.05) << "the spaces differ";
  for (const Developed* d : {&by_points, &by_icc}) EXPECT_LT(largest(d->linear), 0.02) << "linear, of 2 steps of 8 bits";
}

TEST_F(PhonePhotos, TenBitsAreKept) {
  constexpr int kWidth = 512;
  Image16 ramp(kWidth, 16, 3);  // two values for each of 8 bits
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c) ramp.at(x, y, c) = static_cast<uint16_t>(200 + x);
  // HEVC alone: libaom 3.6 ends the program that writes 10 bits.
  const ImageF read = read_unchanged(written("a.heic", heif_bytes(ramp, {.bits = 10})));
  ASSERT_EQ(read.width(), kWidth);
  std::set<float> values;
  double largest = 0;
  for (int x = 0; x < kWidth; ++x) {
    largest = std::max(largest, std::abs(double(read.at(x, 8, 1)) * 1023 - (200 + x)));
    values.insert(read.at(x, 8, 1));
  }
  EXPECT_LT(largest, 1.1) << "in steps of 10 bits";
  EXPECT_GT(values.size(), size_t(kWidth) / 2) << "8 bits hold a quarter of the values";
}

TEST_F(PhonePhotos, ExifOfThePictureIsRead) {
  const std::string exif = test::exif_bytes({{0x010f, 'a', 0, 0, "Maker"}, {0x0110, 'a', 0, 0, "Phone 3"}},
                                            {{0x829a, 'r', 1, 50}, {0x829d, 'r', 18, 10}, {0x8827, 's', 100}, {0xa405, 's', 26}})
                               .substr(6);
  const Developed d = develop(written("a.heic", heif_bytes(phone_picture(), {.exif = exif})), 0);
  EXPECT_EQ(d.photo.camera, "Maker Phone 3");
  EXPECT_NEAR(d.photo.focal_px.value_or(0), 26 * std::hypot(96, 64) / 43.2666, 0.1);
  EXPECT_NEAR(d.photo.exposure_ev.value_or(0), std::log2(1.8 * 1.8 * 50), 1e-6);
}

TEST_F(PhonePhotos, AlphaIsKeptAndNamed) {
  Image8 image(96, 64, 4);
  for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = i % 4 == 3 ? (i / 4 % 96 < 40 ? 0 : 255) : 128;
  const fs::path path = written("a.heic", heif_bytes(image, {.alpha = true}));
  const PhotoHead head = read_photo_head(path);
  EXPECT_TRUE(head.alpha);
  EXPECT_TRUE(has_varying_alpha(path, head));
  EXPECT_FALSE(read_photo_head(written("b.heic", heif_bytes(phone_picture(), {}))).alpha);
}

// Newer phones let the gain map belong to two pictures, which libheif before 1.19 refuses.
TEST_F(PhonePhotos, AuxiliaryPicturesOfTwoPicturesDoNoHarm) {
  Image8 image(96, 64, 4, 255);
  const Image8 rgb = phone_picture();
  for (size_t i = 0; i < rgb.pixel_count(); ++i)
    for (size_t c = 0; c < 3; ++c) image.data()[4 * i + c] = rgb.data()[3 * i + c];
  const std::string plain = heif_bytes(image, {.alpha = true}), shared = test::with_shared_auxiliary(plain);
  if (shared.empty()) GTEST_SKIP() << "libheif " << heif_get_version() << " writes other boxes";
  EXPECT_TRUE(heif_file(plain).shared_auxiliaries.empty());
  ASSERT_EQ(heif_file(shared).shared_auxiliaries.size(), 1u);
  if (heif_get_version_number() < 0x01120000) {  // the case is the one of the phones
    heif_context* const context = heif_context_alloc();
    const heif_error error = heif_context_read_from_memory_without_copy(context, shared.data(), shared.size(), nullptr);
    EXPECT_NE(std::string(error.message ? error.message : "").find("Too many auxiliary"), std::string::npos) << error.message;
    heif_context_free(context);
  }
  EXPECT_LE(largest_step(develop(written("a.heic", shared), 0).linear, rgb), kSteps);
}

TEST_F(PhonePhotos, WhatCannotBeReadIsNamedWithItsRemedy) {
  const std::string bytes = heif_bytes(phone_picture(), {});
  for (const size_t left : {bytes.size() - 1, bytes.size() / 2, size_t(60)}) {
    const std::string text = why(bytes.substr(0, left));
    EXPECT_NE(text.find("cut short; copy it again"), std::string::npos) << left << ": " << text;
  }
  std::string foreign = bytes;  // a coding that no libheif knows
  for (size_t at = 0; (at = foreign.find("hvc1", at)) != std::string::npos;) foreign.replace(at, 4, "zzz1");
  const std::string text = why(foreign);
  for (const char* way : {"libheif 1.", "Most Compatible", "share the photos as JPEG", "heif-convert", "newer libheif"})
    EXPECT_NE(text.find(way), std::string::npos) << text;
}

TEST_F(PhonePhotos, AFolderGivesTheSameAsItsPngTwin) {
  TemporaryFolder heic, png;
  for (int i = 0; i < 3; ++i) {
    const Image8 image = phone_picture(96 + 8 * i, 64);
    write_file(heic.path() / fmt::format("IMG_{}.HEIC", i), heif_bytes(image, {.orientation = i == 1 ? 6 : 1}));
    write_ldr(png.path() / fmt::format("IMG_{}.png", i), i == 1 ? bytes_of(upright(floats_of(image), 6)) : image);
  }
  test::RecordingContext a({{"photos", heic.path()}}), b({{"photos", png.path()}});
  ingest_stage().run(a);
  ingest_stage().run(b);
  const std::vector<Photo> photos = read_photo_list(a.output()), twins = read_photo_list(b.output());
  ASSERT_EQ(photos.size(), 3u);
  ASSERT_EQ(twins.size(), 3u);
  EXPECT_FALSE(a.warnings.contains("PHOTO_TYPES_NOT_READ"));
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(photos[i].name, fmt::format("IMG_{}.png", i));
    EXPECT_EQ(photos[i].source, fmt::format("IMG_{}.HEIC", i));
    EXPECT_EQ(photos[i].original_width, twins[i].original_width);
    const ImageF first = read_exr_rgb(ingested_linear_path(a.output(), photos[i])),
                 second = read_exr_rgb(ingested_linear_path(b.output(), twins[i]));
    EXPECT_LE(largest_step(first, srgb8_from_linear(second)), kSteps);
  }
}

}  // namespace
}  // namespace vitrine

#endif
