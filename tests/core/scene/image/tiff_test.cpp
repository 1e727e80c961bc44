// Every variant of TIFF that holds the same picture is read as that picture, or refused by name.
#include <gtest/gtest.h>

#include "core/scene/image/ldr.h"
#include "core/scene/image/picture_file.h"
#include "core/scene/image/tiff_pages.h"
#include "tests/support/error_of.h"
#include "tests/support/tiff_file.h"

namespace vitrine {
namespace {

using test::TiffDesc;

constexpr int kWidth = 37, kHeight = 29;

class Tiff : public testing::Test {
 protected:
  fs::path written(const TiffDesc& d) const {
    const fs::path path = folder.path() / "a.tif";
    test::write_tiff(path, d, kWidth, kHeight);
    return path;
  }
  std::string refusal(const fs::path& path) const {
    return error_of([&] { read_unchanged(path); }).detail().why;
  }
  TemporaryFolder folder;
};

void expect_picture(const ImageF& read, const Image8& picture, float tolerance, const std::string& name) {
  ASSERT_EQ(read.width(), picture.width()) << name;
  ASSERT_EQ(read.height(), picture.height()) << name;
  ASSERT_EQ(read.channels(), picture.channels()) << name;
  float worst = 0;
  for (size_t i = 0; i < read.data().size(); ++i)
    worst = std::max(worst, std::abs(read.data()[i] - float(picture.data()[i]) / 255.f));
  EXPECT_LE(worst, tolerance) << name;
}

TEST_F(Tiff, EveryLayoutAndSampleTypeGivesTheSamePicture) {
  const unsigned kFloat = SAMPLEFORMAT_IEEEFP;
  std::vector<TiffDesc> all;
  for (const bool planar : {false, true})
    for (const bool tiled : {false, true})
      for (const bool big_endian : {false, true})
        for (const auto& [bits, format] : {std::pair{8u, 1u}, {16u, 1u}, {32u, 1u}, {16u, kFloat}, {32u, kFloat}, {64u, kFloat}})
          for (const unsigned compression : {COMPRESSION_NONE, COMPRESSION_LZW})
            all.push_back({.name = "layout",
                           .bits = bits,
                           .format = format,
                           .compression = compression,
                           .planar = planar,
                           .tiled = tiled,
                           .big = bits == 16,
                           .big_endian = big_endian});
  for (const unsigned compression : {COMPRESSION_ADOBE_DEFLATE, COMPRESSION_DEFLATE, COMPRESSION_PACKBITS, COMPRESSION_LZMA,
                                     COMPRESSION_ZSTD, COMPRESSION_LERC})
    if (TIFFIsCODECConfigured(uint16_t(compression))) all.push_back({.name = "compression", .compression = compression});
  for (const unsigned bits : {8u, 16u, 32u})
    all.push_back({.name = "predictor 2", .bits = bits, .compression = COMPRESSION_LZW, .predictor = 2});
  for (const unsigned bits : {16u, 32u, 64u})
    all.push_back(
        {.name = "predictor 3", .bits = bits, .format = kFloat, .compression = COMPRESSION_ADOBE_DEFLATE, .predictor = 3});
  for (const unsigned bits : {10u, 12u, 14u}) all.push_back({.name = "packed", .bits = bits});
  for (const TiffDesc& d : all) {
    const fs::path path = written(d);
    const std::string name = fmt::format("{}: {} bits, format {}, compression {}, planar {}, tiled {}, big-endian {}", d.name,
                                         d.bits, d.format, d.compression, d.planar, d.tiled, d.big_endian);
    const ImageF first = read_unchanged(path);
    const float tolerance = d.format == kFloat && d.bits == 16 ? 5e-4f : d.bits > 8 && d.bits < 16 ? 1e-3f : 1e-6f;
    expect_picture(first, test::tiff_picture(kWidth, kHeight, 3), tolerance, name);
    EXPECT_EQ(first, read_unchanged(path)) << name;
    const Image8 srgb8 = read_srgb8(path);
    for (size_t i = 0; i < srgb8.data().size(); ++i)
      ASSERT_NEAR(srgb8.data()[i], test::tiff_picture(kWidth, kHeight, 3).data()[i], 1) << name;
  }
}

TEST_F(Tiff, GreyOfEveryDepthAndPolarity) {
  for (const unsigned bits : {1u, 2u, 4u, 8u, 16u, 32u})
    for (const unsigned photometric : {PHOTOMETRIC_MINISBLACK, PHOTOMETRIC_MINISWHITE})
      for (const bool tiled : {false, true}) {
        const TiffDesc d{.bits = bits, .samples = 1, .photometric = photometric, .compression = COMPRESSION_LZW, .tiled = tiled};
        const fs::path path = written(d);
        const Image8 picture = test::tiff_picture(kWidth, kHeight, 1, std::min(bits, 8u));
        expect_picture(read_unchanged(path), picture, 1e-6f, fmt::format("{} bits, photometric {}", bits, photometric));
        EXPECT_EQ(read_grey8(path), picture) << bits;
      }
  const fs::path fax =
      written({.bits = 1, .samples = 1, .photometric = PHOTOMETRIC_MINISWHITE, .compression = COMPRESSION_CCITTFAX4});
  EXPECT_EQ(read_grey8(fax), test::tiff_picture(kWidth, kHeight, 1, 1));
}

TEST_F(Tiff, PalettesAreLookedUp) {
  for (const unsigned bits : {1u, 4u, 8u}) {
    const ImageF read = read_unchanged(written({.bits = bits, .samples = 1, .photometric = PHOTOMETRIC_PALETTE}));
    ASSERT_EQ(read.channels(), 3);
    const unsigned highest = (1u << bits) - 1, index = test::tiff_sample(9, 4, 0, bits) * highest / 255;
    for (unsigned c = 0; c < 3; ++c)
      EXPECT_FLOAT_EQ(read.at(9, 4, int(c)) * 255, float(index * (c + 1) * 255 / highest % 256)) << bits;
  }
}

TEST_F(Tiff, JpegCompressedIsRgbAgain) {
  for (const unsigned photometric : {PHOTOMETRIC_RGB, PHOTOMETRIC_YCBCR})
    for (const bool tiled : {false, true}) {
      TIFF* const tiff = test::open_tiff(folder.path() / "j.tif", {});
      if (photometric == PHOTOMETRIC_YCBCR) {
        TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_JPEG);
        TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
      }
      test::add_tiff_page(tiff, kWidth, kHeight, {.photometric = photometric, .compression = COMPRESSION_JPEG, .tiled = tiled});
      TIFFClose(tiff);
      const ImageF read = read_unchanged(folder.path() / "j.tif");
      ASSERT_EQ(read.channels(), 3);
      ASSERT_EQ(read.width(), kWidth);
      const Image8 picture = test::tiff_picture(kWidth, kHeight, 3);
      for (int c = 0; c < 3; ++c) {
        double sum = 0, wanted = 0;
        for (size_t i = 0; i < picture.pixel_count(); ++i)
          sum += read.data()[3 * i + size_t(c)], wanted += picture.data()[3 * i + size_t(c)] / 255.0;
        EXPECT_NEAR(sum / wanted, 1, 0.02) << photometric << " " << tiled << " " << c;
      }
    }
}

TEST_F(Tiff, YcbcrBecomesRgb) {
  for (const bool tiled : {false, true}) {
    const ImageF read =
        read_unchanged(written({.photometric = PHOTOMETRIC_YCBCR, .compression = COMPRESSION_LZW, .tiled = tiled}));
    ASSERT_EQ(read.channels(), 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double luma = test::tiff_sample(x, y, 0), cb = test::tiff_sample(x, y, 1) - 128.0,
                     cr = test::tiff_sample(x, y, 2) - 128.0;
        const double rgb[] = {luma + 1.402 * cr, luma - 0.344136 * cb - 0.714136 * cr, luma + 1.772 * cb};
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(read.at(x, y, c) * 255, std::clamp(rgb[c], 0.0, 255.0), 2) << x << " " << y << " " << tiled;
      }
  }
}

TEST_F(Tiff, AlphaIsKeptAndDividedOutWhereItWasMultipliedIn) {
  const auto read_with = [&](unsigned samples, unsigned photometric, std::vector<uint16_t> extra, unsigned bits,
                             bool planar = false) {
    return read_unchanged(
        written({.bits = bits, .samples = samples, .photometric = photometric, .planar = planar, .extra = extra}));
  };
  for (const unsigned bits : {8u, 16u}) {
    const Image8 four = test::tiff_picture(kWidth, kHeight, 4);
    expect_picture(read_with(4, PHOTOMETRIC_RGB, {EXTRASAMPLE_UNASSALPHA}, bits), four, 1e-6f, "unassociated");
    expect_picture(read_with(4, PHOTOMETRIC_RGB, {}, bits), four, 1e-6f, "without the tag");
    expect_picture(read_with(4, PHOTOMETRIC_RGB, {EXTRASAMPLE_UNASSALPHA}, bits, true), four, 1e-6f, "planar");
    const ImageF associated = read_with(4, PHOTOMETRIC_RGB, {EXTRASAMPLE_ASSOCALPHA}, bits);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const float alpha = float(four.at(x, y, 3)) / 255.f;
        ASSERT_FLOAT_EQ(associated.at(x, y, 3), alpha);
        if (alpha == 0) continue;
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(associated.at(x, y, c), std::min(four.at(x, y, c) / 255.f / alpha, 1.f), 0.51f / 255.f);
      }
    const ImageF grey = read_with(2, PHOTOMETRIC_MINISBLACK, {EXTRASAMPLE_UNASSALPHA}, bits);
    ASSERT_EQ(grey.channels(), 4);
    EXPECT_FLOAT_EQ(grey.at(5, 6, 2) * 255, float(test::tiff_sample(5, 6, 0)));
    EXPECT_FLOAT_EQ(grey.at(5, 6, 3) * 255, float(test::tiff_sample(5, 6, 1)));
    expect_picture(read_with(5, PHOTOMETRIC_RGB, {0, 0}, bits), test::tiff_picture(kWidth, kHeight, 3), 1e-6f, "two unknown");
  }
  const auto notes = [&](const TiffDesc& d) {
    return fmt::format("{}", fmt::join(examine_picture(read_file(written(d)), ".tif").notes, "; "));
  };
  EXPECT_NE(notes({.samples = 5, .extra = {0, 0}}).find("5 channels: 2 of unknown meaning are left out"), std::string::npos);
  EXPECT_NE(notes({.samples = 4, .extra = {EXTRASAMPLE_ASSOCALPHA}}).find("divided by it"), std::string::npos);
  EXPECT_EQ(notes({}), "");
}

TEST_F(Tiff, ThePictureIsTheLargestFullPage) {
  const auto pages = [&](const std::vector<std::tuple<int, int, unsigned>>& sizes, bool big) {
    TIFF* const tiff = test::open_tiff(folder.path() / "pages.tif", {.big = big});
    unsigned offset = 0;
    for (const auto& [w, h, subfile] : sizes) test::add_tiff_page(tiff, w, h, {.subfile = subfile}, offset++);
    TIFFClose(tiff);
    return folder.path() / "pages.tif";
  };
  for (const bool big : {false, true}) {
    const fs::path thumbnail_first = pages({{24, 16, FILETYPE_REDUCEDIMAGE}, {kWidth, kHeight, 0}}, big);
    EXPECT_EQ(read_unchanged(thumbnail_first).width(), kWidth);
    EXPECT_EQ(probe_photo(read_file(thumbnail_first)).width, size_t(kWidth));
    EXPECT_EQ(read_unchanged(pages({{24, 16, 0}, {kWidth, kHeight, 0}}, big)).width(), kWidth)
        << "a thumbnail that does not say so";
    EXPECT_EQ(read_unchanged(pages({{kWidth, kHeight, 0}, {80, 60, FILETYPE_MASK}}, big)).width(), kWidth) << "a larger mask";
    const fs::path equal = pages({{kWidth, kHeight, FILETYPE_PAGE}, {kWidth, kHeight, FILETYPE_PAGE}}, big);
    expect_picture(read_unchanged(equal), test::tiff_picture(kWidth, kHeight, 3), 1e-6f, "the first of equal pages");
    const auto notes = examine_picture(read_file(equal), ".tif").notes;
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_EQ(notes[0], "a TIFF of 2 pages of equal size: the first is read");
  }
  // The picture in a sub-directory of a thumbnail.
  TIFF* const tiff = test::open_tiff(folder.path() / "sub.tif", {});
  toff_t places[1] = {0};
  TIFFSetField(tiff, TIFFTAG_SUBIFD, 1, places);
  test::add_tiff_page(tiff, 12, 10, {.subfile = FILETYPE_REDUCEDIMAGE});
  test::add_tiff_page(tiff, kWidth, kHeight, {});
  TIFFClose(tiff);
  expect_picture(read_unchanged(folder.path() / "sub.tif"), test::tiff_picture(kWidth, kHeight, 3), 1e-6f, "sub-directory");
}

TEST_F(Tiff, DirectoriesInACircleAndSizesThatNoFileHoldsDoNoHarm) {
  std::string bytes = read_file(written({}));
  const uint64_t directory = tiff_pages(bytes).chosen().directory;
  const size_t entries = uint8_t(bytes[directory]) + 256u * uint8_t(bytes[directory + 1]);
  const uint32_t itself = uint32_t(directory);
  std::memcpy(&bytes[directory + 2 + 12 * entries], &itself, 4);
  write_file(folder.path() / "circle.tif", bytes);
  expect_picture(read_unchanged(folder.path() / "circle.tif"), test::tiff_picture(kWidth, kHeight, 3), 1e-6f, "circle");
  EXPECT_EQ(examine_picture(bytes, ".tif").notes,
            std::vector<std::string>{"a TIFF with damaged further pages: they are left out"});
  const uint32_t large = 16000;
  for (size_t i = 0; i < 2; ++i) {  // width and height are the first entries
    std::memcpy(&bytes[directory + 2 + 12 * i + 2], "\x04\0", 2);
    std::memcpy(&bytes[directory + 2 + 12 * i + 8], &large, 4);
  }
  write_file(folder.path() / "large.tif", bytes);
  EXPECT_NE(refusal(folder.path() / "large.tif").find("cannot hold 16000 x 16000"), std::string::npos)
      << refusal(folder.path() / "large.tif");
}

TEST_F(Tiff, WhatIsNotReadIsNamedWithTheWayOut) {
  const auto has = [&](const TiffDesc& d, std::string_view words) {
    const std::string why = refusal(written(d));
    EXPECT_NE(why.find(words), std::string::npos) << why;
    EXPECT_EQ(why.find("damaged"), std::string::npos) << why;
  };
  has({.samples = 4, .photometric = PHOTOMETRIC_SEPARATED}, "CMYK");
  has({.photometric = PHOTOMETRIC_CIELAB}, "Lab");
  has({.format = SAMPLEFORMAT_INT}, "signed");
  has({.bits = 24, .format = SAMPLEFORMAT_IEEEFP}, "floating-point samples of 24 bits");
  has({.bits = 16, .samples = 1, .photometric = PHOTOMETRIC_CFA}, "raw photo");
}

TEST_F(Tiff, ACutFileIsRefusedWithTheStripThatIsMissing) {
  for (const TiffDesc& d :
       {TiffDesc{}, TiffDesc{.compression = COMPRESSION_LZW}, TiffDesc{.bits = 16, .planar = true},
        TiffDesc{.compression = COMPRESSION_ADOBE_DEFLATE, .tiled = true}, TiffDesc{.compression = COMPRESSION_PACKBITS}}) {
    // The directory before the strips, as cameras write it: with it at the end a cut file has none.
    const std::string whole = read_file(written(d));
    const TiffPages pages = tiff_pages(whole);
    std::string cut = whole;
    const size_t first = 300, last = whole.size() - 300;  // zero bytes in the middle of what is compressed, or a cut
    if (d.compression == COMPRESSION_NONE) {
      cut.erase(first, 200);
      write_file(folder.path() / "cut.tif", cut);
      EXPECT_THROW(read_unchanged(folder.path() / "cut.tif"), Error);
      continue;
    }
    for (size_t i = first; i < std::min(last, first + 60); ++i) cut[i] = '\x55';
    write_file(folder.path() / "cut.tif", cut);
    try {
      EXPECT_EQ(read_unchanged(folder.path() / "cut.tif"), read_unchanged(folder.path() / "cut.tif"));
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::Input);
    }
  }
  // Strips that lie behind the end of the file.
  std::string plain = read_file(written({}));
  const size_t strips = size_t(tiff_pages(plain).chosen().directory);
  ASSERT_GT(strips, 1000u);
  plain.erase(1000, 1500);
  const uint32_t moved = uint32_t(strips - 1500);
  std::memcpy(&plain[4], &moved, 4);
  write_file(folder.path() / "cut.tif", plain);
  EXPECT_NE(refusal(folder.path() / "cut.tif"), "");
  EXPECT_NE(refusal([&] {
              write_file(folder.path() / "none.tif", std::string("II*\0\x00\x10\0\0", 8));
              return folder.path() / "none.tif";
            }())
                .find("truncated"),
            std::string::npos);
}

}  // namespace
}  // namespace vitrine
