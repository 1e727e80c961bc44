// The colours of photos: what a file says of them is what becomes linear Rec. 709.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/image/color_profile.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/segments.h"
#include "core/foundation/math/color.h"
#include "core/intake/photos/linear_photo.h"
#include "stages/ingest/develop.h"
#include "stages/ingest/ingest.h"
#include "tests/stages/ingest/tagged_photos.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

// Blocks of 16 pixels, so that JPEG keeps them apart. Linear Rec. 709: inside of sRGB, and, `saturated`, outside of it but inside
// of Display P3, Adobe RGB and ProPhoto RGB.
ImageF coloured_blocks(bool saturated = false) {
  const float inside[6][3] = {{0.55f, 0.05f, 0.04f}, {0.05f, 0.45f, 0.08f}, {0.03f, 0.05f, 0.5f},
                              {0.6f, 0.5f, 0.05f},   {0.21f, 0.21f, 0.21f}, {0.65f, 0.66f, 0.62f}};
  const float outside[6][3] = {{-0.01f, 0.5f, 0.08f}, {-0.015f, 0.6f, 0.2f}, {-0.02f, 0.5f, 0.03f},
                               {-0.01f, 0.3f, 0.2f},  {-0.02f, 0.7f, 0.3f},  {-0.008f, 0.25f, 0.05f}};
  const auto& blocks = saturated ? outside : inside;
  ImageF image(48, 32, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 48; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = blocks[y / 16 * 3 + x / 16][c];
  return image;
}

ImageF in_space(const ImageF& linear, const test::Profile& profile) {
  return test::converted(linear, test::linear_rec709(), profile);
}

// Encoded as sRGB below and above, so that a step means the same everywhere.
double steps_apart(const ImageF& a, const ImageF& b) {
  if (a.width() != b.width() || a.height() != b.height()) return 1e9;
  const auto encoded = [](float v) { return std::copysign(srgb_from_linear(std::abs(double(v))), double(v)); };
  double largest = 0;
  for (size_t i = 0; i < a.data().size(); ++i)
    largest = std::max(largest, 255 * std::abs(encoded(a.data()[i]) - encoded(b.data()[i])));
  return largest;
}
// In the middle of the blocks: JPEG blurs colour across their borders.
double steps_apart_inside(const ImageF& a, const ImageF& b) {
  ImageF inside_a(6, 4, 3), inside_b(6, 4, 3);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 6; ++x)
      for (int c = 0; c < 3; ++c) {
        const int u = 16 * (x / 2) + 7 + x % 2, v = 16 * (y / 2) + 7 + y % 2;
        inside_a.at(x, y, c) = a.at(u, v, c), inside_b.at(x, y, c) = b.at(u, v, c);
      }
  return steps_apart(inside_a, inside_b);
}
double largest_difference(const ImageF& a, const ImageF& b) {
  if (a.data().size() != b.data().size()) return 1e9;
  double largest = 0;
  for (size_t i = 0; i < a.data().size(); ++i) largest = std::max(largest, std::abs(double(a.data()[i]) - b.data()[i]));
  return largest;
}

PhotoColor color_at(const fs::path& path) { return read_photo_head(path).color; }
ImageF developed(const fs::path& path) { return ingest::develop(path, 0).linear; }

class Colors : public ::testing::Test {
 protected:
  fs::path path(const std::string& name) const { return folder_.path() / name; }
  fs::path png8(const std::string& name, const ImageF& encoded, const std::string& chunks = {}) const {
    write_ldr(path(name), test::in_8_bits(encoded));
    if (!chunks.empty()) test::add_to_png(path(name), chunks);
    return path(name);
  }
  fs::path png16(const std::string& name, const ImageF& encoded, const std::string& chunks = {}) const {
    write_png16(path(name), test::in_16_bits(encoded));
    if (!chunks.empty()) test::add_to_png(path(name), chunks);
    return path(name);
  }
  fs::path jpeg(const std::string& name, const ImageF& encoded) const {
    write_ldr(path(name), test::in_8_bits(encoded), 100);
    return path(name);
  }
  TemporaryFolder folder_;
};

TEST_F(Colors, OnePictureInFourSpacesIsOneLinearPicture) {
  const ImageF truth = coloured_blocks();
  const std::string p3 = test::icc_bytes(test::display_p3()), adobe = test::icc_bytes(test::adobe_rgb());
  png8("srgb.png", srgb_from_linear_image(truth));
  png8("p3.png", in_space(truth, test::display_p3()), test::icc_chunk(p3));
  png8("adobe.png", in_space(truth, test::adobe_rgb()), test::icc_chunk(adobe));
  for (const char* name : {"srgb.png", "p3.png", "adobe.png"}) {
    EXPECT_LE(largest_difference(developed(path(name)), truth), 1.0 / 255) << name;
    EXPECT_LE(steps_apart(developed(path(name)), truth), 1.5) << name << ": what 8 bits of another space leave";
  }
  const Image16 wide = test::in_16_bits(in_space(truth, test::prophoto()));
  for (bool big : {false, true}) {
    const std::string tiff = test::tagged_tiff(wide, test::icc_bytes(test::prophoto()), big);
    EXPECT_EQ(tiff_profile(tiff), test::icc_bytes(test::prophoto())) << big;
  }
  write_file(path("prophoto.tif"), test::tagged_tiff(wide, test::icc_bytes(test::prophoto())));
  EXPECT_LE(steps_apart(developed(path("prophoto.tif")), truth), 0.1);
  // A JPEG rounds luma and chroma to 8 bits before the matrix.
  test::add_icc_to_jpeg(jpeg("p3.jpg", in_space(truth, test::display_p3())), p3);
  EXPECT_LE(steps_apart_inside(developed(path("p3.jpg")), truth), 3);
  EXPECT_EQ(color_at(path("p3.jpg")).profile->name(), "Display P3");
  EXPECT_EQ(color_at(path("adobe.png")).profile->name(), "Adobe RGB (1998)");
  EXPECT_EQ(color_at(path("prophoto.tif")).profile->name(), "ProPhoto RGB");
  EXPECT_EQ(color_at(path("prophoto.tif")).source, "icc");
  EXPECT_EQ(color_at(path("srgb.png")).source, "assumed sRGB");
}

TEST_F(Colors, OutsideOfSrgbAreKeptAndAgree) {
  const ImageF truth = coloured_blocks(true);
  const std::string p3 = test::icc_bytes(test::display_p3()), adobe = test::icc_bytes(test::adobe_rgb());
  write_file(path("prophoto.tif"),
             test::tagged_tiff(test::in_16_bits(in_space(truth, test::prophoto())), test::icc_bytes(test::prophoto())));
  const ImageF seen[] = {developed(png16("p3.png", in_space(truth, test::display_p3()), test::icc_chunk(p3))),
                         developed(png16("adobe.png", in_space(truth, test::adobe_rgb()), test::icc_chunk(adobe))),
                         developed(path("prophoto.tif"))};
  for (const ImageF& s : seen) EXPECT_LE(largest_difference(s, truth), 1.0 / 255);
  EXPECT_LT(seen[0].at(0, 0, 0), -0.005f) << "the negative red is still there";
}

TEST_F(Colors, TheMatrixAgreesWithLittleCms) {
  Rng rng(7);
  ImageF encoded(64, 64, 3);
  for (float& v : encoded.data()) v = float(rng.below(65536)) / 65535.0f;
  for (const test::Profile& profile : {test::display_p3(), test::adobe_rgb(), test::prophoto()}) {
    const IccProfile icc = icc_profile(test::icc_bytes(profile));
    ASSERT_TRUE(icc.profile) << icc.problem;
    ImageF ours = encoded, floats = encoded;
    icc.profile->to_linear(ours);
    icc.profile->float_to_linear(floats);
    const ImageF theirs = test::converted(encoded, profile, test::linear_rec709());
    EXPECT_LE(largest_difference(ours, theirs), 1e-4) << icc.profile->name();
    EXPECT_LE(largest_difference(floats, theirs), 1e-4) << icc.profile->name();
  }
}

TEST_F(Colors, SrgbStaysBitForBitWhateverSaysSo) {
  const ImageF encoded = srgb_from_linear_image(coloured_blocks());
  const ImageF plain = developed(png8("plain.png", encoded));
  // A small profile: the curve as 64 numbers; and one without a name that helps.
  std::vector<uint16_t> few(64);
  for (size_t i = 0; i < few.size(); ++i) few[i] = uint16_t(std::lround(65535 * linear_from_srgb(double(i) / 63)));
  const test::Profile variants[] = {
      test::rgb_profile(kRec709, test::srgb_tone(), "c2"), test::owned(cmsCreate_sRGBProfile()),
      test::table_profile(test::owned(cmsCreate_sRGBProfile()), 33),
      test::rgb_profile(kRec709, cmsBuildTabulatedToneCurve16(nullptr, 64, few.data()), "a monitor")};
  for (const test::Profile& variant : variants) {
    const fs::path tagged = png8("tagged.png", encoded, test::icc_chunk(test::icc_bytes(variant)));
    EXPECT_TRUE(color_at(tagged).profile->is_srgb());
    EXPECT_EQ(color_at(tagged).source, "icc");
    EXPECT_EQ(developed(tagged), plain);
  }
  EXPECT_EQ(developed(png8("chunk.png", encoded, test::png_chunk("sRGB", std::string(1, '\0')))), plain);
  const std::string usual =
      test::numbers_chunk("gAMA", {45455}) + test::numbers_chunk("cHRM", {31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000});
  EXPECT_EQ(developed(png8("gama.png", encoded, usual)), plain);
  EXPECT_EQ(developed(png8("cicp.png", encoded, test::png_chunk("cICP", {1, 13, 0, 1}))), plain);
  // Another curve of the same primaries is no sRGB.
  const std::string gamma22 = test::icc_bytes(test::rgb_profile(kRec709, cmsBuildGamma(nullptr, 2.2), "sRGB IEC61966-2.1"));
  EXPECT_FALSE(icc_profile(gamma22).profile->is_srgb());
}

TEST_F(Colors, PartsOfAProfileComeInAnyOrderAndInAnyNumber) {
  const ImageF truth = coloured_blocks();
  std::string large = test::icc_bytes(test::display_p3());
  large.resize(200'000);
  const ImageF encoded = in_space(truth, test::display_p3());
  for (const std::vector<size_t>& order : {std::vector<size_t>{1, 2, 3, 4}, {3, 1, 4, 2}, {4, 3, 2, 1}}) {
    test::add_icc_to_jpeg(jpeg("p3.jpg", encoded), large, 4, order);
    EXPECT_EQ(color_at(path("p3.jpg")).profile->name(), "Display P3");
    EXPECT_LE(steps_apart_inside(developed(path("p3.jpg")), truth), 3);
  }
  test::add_icc_to_jpeg(jpeg("missing.jpg", encoded), large, 4, {1, 2, 4, 4});
  EXPECT_TRUE(color_at(path("missing.jpg")).profile->is_srgb());
  EXPECT_NE(color_at(path("missing.jpg")).problem.find("part 3 of the 4 parts"), std::string::npos);
}

TEST_F(Colors, ChunksOfPngNameThemToo) {
  const ImageF truth = coloured_blocks();
  const std::string p3 = test::icc_bytes(test::display_p3()), adobe = test::icc_bytes(test::adobe_rgb());
  const ImageF encoded = in_space(truth, test::display_p3());
  // cICP wins over everything else.
  const fs::path cicp = png8("cicp.png", encoded, test::png_chunk("cICP", {12, 13, 0, 1}) + test::icc_chunk(adobe));
  EXPECT_LE(steps_apart(developed(cicp), truth), 1.5);
  EXPECT_EQ(color_at(cicp).source, "png cICP");
  EXPECT_EQ(color_at(cicp).profile->name(), "Display P3");
  // gAMA 1.0: linear.
  EXPECT_LE(largest_difference(developed(png16("linear.png", truth, test::numbers_chunk("gAMA", {100000}))), truth), 1e-4);
  // gAMA and cHRM of Adobe RGB.
  const std::string chunks =
      test::numbers_chunk("gAMA", {45470}) + test::numbers_chunk("cHRM", {31270, 32900, 64000, 33000, 21000, 71000, 15000, 6000});
  const fs::path chrm = png16("chrm.png", in_space(truth, test::adobe_rgb()), chunks);
  EXPECT_EQ(color_at(chrm).source, "png gAMA, cHRM");
  EXPECT_LE(steps_apart(developed(chrm), truth), 8) << "45470 stands for the curve of sRGB";
  // A power that is none of the usual ones.
  ImageF power = truth;
  for (float& v : power.data()) v = std::pow(v, 1 / 1.8f);
  EXPECT_LE(steps_apart(developed(png16("power.png", power, test::numbers_chunk("gAMA", {55556}))), truth), 0.1);
  // Nonsense.
  const fs::path odd = png8("odd.png", encoded, test::png_chunk("cICP", "\xc8\x0d" + std::string("\0\1", 2)));
  EXPECT_TRUE(color_at(odd).profile->is_srgb());
  EXPECT_NE(color_at(odd).problem.find("cICP"), std::string::npos);
  const fs::path impossible = png8("impossible.png", encoded,
                                   test::numbers_chunk("gAMA", {50000}) + test::numbers_chunk("cHRM", {0, 0, 1, 1, 1, 1, 1, 1}));
  EXPECT_NE(color_at(impossible).problem.find("cHRM"), std::string::npos);
}

TEST_F(Colors, ExifTellsAdobeRgbFromSrgb) {
  const ImageF truth = coloured_blocks();
  const auto with_exif = [&](const char* name, unsigned space, const char* interoperability) {
    // The directory of interoperability stands behind the two others; its offset is in the EXIF directory.
    std::vector<test::Tag> exif{{0xa001, 's', space}};
    const std::vector<test::Tag> interop{{0x0001, 'a', 0, 1, interoperability}};
    exif.push_back({0xa005, 'l', 0});
    const size_t at = test::exif_bytes({}, exif).size() - 6;
    exif.back().a = static_cast<unsigned>(at);
    const std::string block = test::exif_bytes({}, exif) + test::directory(interop, static_cast<unsigned>(at), false);
    test::add_exif(jpeg(name, in_space(truth, test::adobe_rgb())), block);
    return path(name);
  };
  const fs::path adobe = with_exif("_adobe.jpg", 0xffff, "R03");
  EXPECT_EQ(color_at(adobe).profile->name(), "Adobe RGB (1998)");
  EXPECT_EQ(color_at(adobe).source, "exif InteroperabilityIndex");
  EXPECT_LE(steps_apart_inside(developed(adobe), truth), 3);
  EXPECT_EQ(color_at(with_exif("two.jpg", 2, "R98")).profile->name(), "Adobe RGB (1998)");
  const fs::path srgb = with_exif("srgb.jpg", 1, "R98");
  EXPECT_TRUE(color_at(srgb).profile->is_srgb());
  EXPECT_EQ(color_at(srgb).source, "exif ColorSpace");
  const PhotoColor open = color_at(with_exif("open.jpg", 0xffff, "R98"));
  EXPECT_TRUE(open.profile->is_srgb());
  EXPECT_NE(open.problem.find("uncalibrated"), std::string::npos);
  // A profile wins.
  test::add_icc_to_jpeg(adobe, test::icc_bytes(test::display_p3()));
  EXPECT_EQ(color_at(adobe).profile->name(), "Display P3");
}

TEST_F(Colors, BrokenProfilesAreSrgbWithTheCause) {
  const ImageF encoded = srgb_from_linear_image(coloured_blocks());
  const ImageF plain = developed(png8("plain.png", encoded));
  const std::string p3 = test::icc_bytes(test::display_p3());
  std::string no_magic = p3, no_curve = p3;
  no_magic[36] = 'x';
  no_curve.replace(no_curve.find("rTRC"), 4, "xxxx");
  const std::string broken[] = {"no profile", std::string(500, '\0'), p3.substr(0, 140), no_magic, no_curve};
  for (const std::string& icc : broken) {
    const fs::path tagged = png8("tagged.png", encoded, test::icc_chunk(icc));
    const PhotoColor color = color_at(tagged);
    EXPECT_TRUE(color.profile->is_srgb());
    EXPECT_NE(color.problem, "") << icc.size();
    EXPECT_EQ(developed(tagged), plain);
  }
  const fs::path packed = png8("packed.png", encoded, test::png_chunk("iCCP", std::string("p\0\0junk", 7)));
  EXPECT_NE(color_at(packed).problem.find("iCCP"), std::string::npos);
  // Every byte of a profile may be damaged: never a crash, never a number that is none.
  Rng rng(3);
  for (int i = 0; i < 400; ++i) {
    std::string damaged = p3;
    for (int k = 0; k < 1 + i % 4; ++k) damaged[rng.below(damaged.size())] = static_cast<char>(rng.below(256));
    const IccProfile icc = icc_profile(damaged);
    if (!icc.profile) {
      EXPECT_NE(icc.problem, "");
      continue;
    }
    ImageF image = encoded;
    icc.profile->to_linear(image);
    for (float v : image.data()) ASSERT_TRUE(std::isfinite(v)) << i;
  }
}

TEST_F(Colors, GreyProfilesAreForGreyPictures) {
  cmsToneCurve* const gamma = cmsBuildGamma(nullptr, 1.8);
  const std::string grey = test::icc_bytes(test::owned(cmsCreateGrayProfile(cmsD50_xyY(), gamma)));
  cmsFreeToneCurve(gamma);
  Image8 ramp(64, 16, 1);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 64; ++x) ramp.at(x, y) = static_cast<uint8_t>(4 * x);
  write_ldr(path("grey.png"), ramp);
  test::add_to_png(path("grey.png"), test::icc_chunk(grey));
  write_ldr(path("grey.jpg"), ramp, 100);
  test::add_icc_to_jpeg(path("grey.jpg"), grey);
  for (const char* name : {"grey.png", "grey.jpg"}) {
    EXPECT_EQ(color_at(path(name)).source, "icc") << color_at(path(name)).problem;
    const ImageF linear = developed(path(name));
    for (int x = 0; x < 64; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(linear.at(x, 8, c), std::pow(4.0 * x / 255, 1.8), 0.01) << name;
  }
  const fs::path odd = png8("odd.png", srgb_from_linear_image(coloured_blocks()), test::icc_chunk(grey));
  EXPECT_NE(color_at(odd).problem.find("grey"), std::string::npos);
}

TEST_F(Colors, OfPrintAreRefused) {
  const test::Profile p = test::owned(cmsCreateProfilePlaceholder(nullptr));
  cmsSetDeviceClass(p.get(), cmsSigOutputClass);
  cmsSetColorSpace(p.get(), cmsSigCmykData);
  cmsSetPCS(p.get(), cmsSigLabData);
  jpeg("print.jpg", srgb_from_linear_image(coloured_blocks()));
  test::add_icc_to_jpeg(path("print.jpg"), test::icc_bytes(p));
  const Error error = error_of([&] { developed(path("print.jpg")); });
  EXPECT_EQ(error.kind(), ErrorKind::Input);
  EXPECT_NE(error.detail().why.find("print"), std::string::npos);
}

TEST_F(Colors, ProfilesThatAreTablesGoThroughLittleCms) {
  const test::Profile p3 = test::display_p3(), scanner = test::table_profile(p3, 17);
  const ImageF truth = coloured_blocks();
  const fs::path tagged = png16("p3.png", in_space(truth, p3), test::icc_chunk(test::icc_bytes(scanner)));
  EXPECT_EQ(color_at(tagged).problem, "");
  EXPECT_EQ(color_at(tagged).source, "icc");
  EXPECT_LE(steps_apart(developed(tagged), truth), 6) << "what 17 steps of a curve leave";
}

TEST_F(Colors, ChromaticitiesOfAnExrAreApplied) {
  ImageF truth(16, 16, 3);
  for (size_t i = 0; i < truth.data().size(); ++i) truth.data()[i] = coloured_blocks().data()[i * 2] * 3;  // beyond 1, too
  const Chromaticities aces{0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767};
  const test::Profile acescg = test::rgb_profile(aces, cmsBuildGamma(nullptr, 1.0), "ACEScg");
  write_exr_rgb(path("aces.exr"), in_space(truth, acescg), ExrPrecision::Float);
  test::add_chromaticities(path("aces.exr"), aces);
  EXPECT_EQ(color_at(path("aces.exr")).profile->name(), "linear ACEScg");
  EXPECT_LE(largest_difference(developed(path("aces.exr")), truth), 1e-3);
  write_exr_rgb(path("plain.exr"), truth, ExrPrecision::Float);
  const ImageF plain = developed(path("plain.exr"));
  EXPECT_EQ(plain, truth);
  test::add_chromaticities(path("plain.exr"), kRec709);
  EXPECT_EQ(developed(path("plain.exr")), truth);
  write_exr_rgb(path("odd.exr"), truth, ExrPrecision::Float);
  test::add_chromaticities(path("odd.exr"), {});
  EXPECT_NE(color_at(path("odd.exr")).problem, "");
  EXPECT_EQ(developed(path("odd.exr")), truth);
}

TEST_F(Colors, IngestNamesProfilesAndWarnsOfMixtures) {
  const ImageF truth = coloured_blocks();
  const std::string p3 = test::icc_bytes(test::display_p3());
  const ImageF encoded = in_space(truth, test::display_p3());
  png8("a.png", encoded, test::icc_chunk(p3));
  png8("b.png", encoded, test::icc_chunk(p3));
  const auto run = [&] {
    test::RecordingContext context({{"photos", folder_.path()}});
    Stage stage = ingest_stage();
    stage.run(context);
    const std::vector<Photo> photos = read_photo_list(context.output());
    EXPECT_EQ(photos.at(0).color_profile, "Display P3");
    EXPECT_EQ(photos.at(0).color_source, "icc");
    return std::pair(context.summary_text, context.warnings);
  };
  auto [summary, warnings] = run();
  EXPECT_NE(summary.find("2 photos Display P3 -> linear Rec. 709"), std::string::npos) << summary;
  for (const char* code : {"PHOTO_PROFILES_DIFFER", "PHOTO_PROFILE_UNUSABLE", "PHOTO_ALPHA_NOT_USED"})
    EXPECT_FALSE(warnings.contains(code)) << code;
  jpeg("c.jpg", srgb_from_linear_image(truth));
  png8("d.png", encoded, test::icc_chunk("damaged"));
  std::tie(summary, warnings) = run();
  ASSERT_TRUE(warnings.contains("PHOTO_PROFILES_DIFFER"));
  EXPECT_NE(warnings["PHOTO_PROFILES_DIFFER"].find("2 x Display P3, 2 x sRGB"), std::string::npos);
  EXPECT_NE(warnings["PHOTO_PROFILE_UNUSABLE"].find("1 photo"), std::string::npos);
}

TEST_F(Colors, AlphaThatVariesIsMentioned) {
  const ImageF truth = coloured_blocks();
  const auto with_alpha = [&](uint16_t hidden) {
    Image16 image(48, 32, 4);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 48; ++x)
        for (int c = 0; c < 4; ++c)
          image.at(x, y, c) = c == 3 ? (x < 20 ? hidden : 65535) : uint16_t(65535 * srgb_from_linear(truth.at(x, y, c)));
    return test::tagged_tiff(image, "");
  };
  write_file(path("a.tif"), with_alpha(0));
  write_file(path("b.tif"), with_alpha(65535));
  jpeg("c.jpg", srgb_from_linear_image(truth));
  EXPECT_TRUE(has_varying_alpha(path("a.tif"), read_photo_head(path("a.tif"))));
  EXPECT_FALSE(has_varying_alpha(path("b.tif"), read_photo_head(path("b.tif"))));
  EXPECT_EQ(developed(path("a.tif")), developed(path("b.tif"))) << "the colours are those of the file";
  test::RecordingContext context({{"photos", folder_.path()}});
  Stage stage = ingest_stage();
  stage.run(context);
  EXPECT_NE(context.warnings["PHOTO_ALPHA_NOT_USED"].find("1 photo has an alpha channel"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
