// HEIC and raw photos in the report: the facts of ingest, known before any computation.
#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/scene/image/ldr.h"
#include "stages/inspect/inspect.h"
#include "tests/support/dng_file.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_photos.h"
#ifdef VITRINE_WITH_LIBHEIF
#include "tests/support/heif_writer.h"
#endif

namespace vitrine {
namespace {

nlohmann::json report_of(const fs::path& folder) {
  test::RecordingContext context({{"photos", folder}});
  const Stage stage = inspect_stage();
  stage.run(context);
  return nlohmann::json::parse(read_file(context.output() / "inspect" / "report.json"));
}

const nlohmann::json* finding(const nlohmann::json& report, const std::string& code) {
  for (const auto& f : report["findings"])
    if (f["code"] == code) return &f;
  return nullptr;
}

Image8 slope() {
  Image8 image(96, 64, 3);
  for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = static_cast<uint8_t>(40 + i / 3 % 96);
  return image;
}

#ifdef VITRINE_WITH_LIBHEIF
TEST(CameraPhotos, HeicHasItsSizeCameraAndColours) {
  if (!test::heif_encodes(heif_compression_HEVC)) GTEST_SKIP() << "libheif has no encoder of HEVC: libheif-plugin-x265";
  TemporaryFolder folder;
  const std::string exif = test::exif_bytes({{0x010f, 'a', 0, 0, "Maker"}, {0x0112, 's', 6}}, {{0xa405, 's', 26}}).substr(6);
  const std::string bytes = test::heif_bytes(slope(), {.orientation = 6, .primaries = 12, .exif = exif});
  write_file(folder.path() / "a.heic", bytes);
  write_file(folder.path() / "b.heic", bytes.substr(0, bytes.size() / 2));
  write_ldr(folder.path() / "c.png", slope());
  const nlohmann::json report = report_of(folder.path());
  const nlohmann::json& photo = report["photos"][0];
  EXPECT_EQ(photo["name"], "a.png");
  EXPECT_EQ(photo["width"], 64);
  EXPECT_EQ(photo["height"], 96);
  EXPECT_EQ(photo["camera"], "Maker");
  EXPECT_EQ(photo["color_profile"], "Display P3");
  EXPECT_NEAR(photo["focal_px"].get<double>(), 26 * std::hypot(96, 64) / 43.2666, 0.1);
  EXPECT_EQ(finding(report, "types_not_read"), nullptr);
  const nlohmann::json* const unreadable = finding(report, "unreadable_photos");
  ASSERT_NE(unreadable, nullptr);
  EXPECT_NE(unreadable->dump().find("cut short; copy it again"), std::string::npos) << unreadable->dump();
}
#endif

#ifdef VITRINE_WITH_LIBRAW
TEST(CameraPhotos, RawAndItsJpegAreOnePhoto) {
  TemporaryFolder folder;
  const auto colour = [](int x, int y) { return Vec3d{x / 96.0, 0.4, y / 96.0}; };
  write_file(folder.path() / "a.dng", test::dng_bytes({.orientation = 8}, colour));
  write_ldr(folder.path() / "a.jpg", slope());
  write_file(folder.path() / "b.dng", test::dng_bytes({.matrix = false}, colour));
  write_ldr(folder.path() / "c.png", slope());
  const nlohmann::json report = report_of(folder.path());
  const nlohmann::json& photo = report["photos"][0];
  EXPECT_EQ(photo["name"], "a.png");
  EXPECT_EQ(photo["width"], 64);
  EXPECT_EQ(photo["camera"], "Maker Model R");
  EXPECT_EQ(photo["color_source"], "camera raw");
  EXPECT_NE(finding(report, "photos_in_two_formats"), nullptr) << report["findings"].dump(1);
  const nlohmann::json* const unreadable = finding(report, "unreadable_photos");
  ASSERT_NE(unreadable, nullptr);
  EXPECT_NE(unreadable->dump().find("(Maker Model R)"), std::string::npos) << unreadable->dump();
}
#endif

}  // namespace
}  // namespace vitrine
