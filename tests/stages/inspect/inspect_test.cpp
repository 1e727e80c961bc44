// Measures against pictures whose blur is known, findings against folders made to show them, gaps against rings with a hole.
#include "stages/inspect/inspect.h"

#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/scene/image/ldr.h"
#include "stages/inspect/coverage.h"
#include "stages/inspect/photo_facts.h"
#include "tests/stages/inspect/drawn_photos.h"
#include "tests/support/error_of.h"
#include "tests/support/gps_exif.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using test::RecordingContext, test::smeared, test::wall;

TEST(Measures, TellTheBlurOfEdgesInPixels) {
  const Image8 sharp = wall(480, 360, 1);
  EXPECT_LT(measured(sharp).blur_px.value(), 0.5);
  for (double sigma : {1.0, 2.0, 3.0}) {  // worst seen 6 % off
    const PhotoMeasures m = measured(smeared(sharp, sigma, sigma));
    EXPECT_NEAR(m.blur_px.value(), sigma, 0.15 * sigma);
    EXPECT_LT(m.blur_ratio, 1.4);
  }
}

TEST(Measures, TellMotionFromFocus) {
  const PhotoMeasures moved = measured(smeared(wall(480, 360, 1), 3, 0));
  EXPECT_NEAR(moved.blur_px.value(), 3, 0.6);
  EXPECT_GT(moved.blur_ratio, 3);
}

TEST(Measures, OfAFlatPictureSayThatThereIsNothing) {
  const PhotoMeasures flat = measured(Image8(64, 48, 3, 90));
  EXPECT_FALSE(flat.blur_px.has_value());
  EXPECT_EQ(flat.texture, 0);
  EXPECT_TRUE(flat.thumbnail.empty());
  EXPECT_EQ(likeness(flat, flat), 0);
}

TEST(Measures, LikenessIgnoresExposureAndSeesAStep) {
  const PhotoMeasures a = measured(wall(480, 360, 1)), darker = measured(wall(480, 360, 1, 0, 0.5)),
                      moved = measured(wall(480, 360, 1, 12));
  EXPECT_GT(likeness(a, darker), kSamePicture);
  EXPECT_LT(likeness(a, moved), 0.97);
  EXPECT_NEAR(a.brightness_ev - darker.brightness_ev, 2.2, 0.4) << "half the sRGB value is about a fifth of the light";
}

// --- folders ----------------------------------------------------------------------------------------------------------------

class Folder {
 public:
  void add(const Image8& image, const std::string& name = {}) {
    write_ldr(folder_.path() / (name.empty() ? fmt::format("{:02}.jpg", n_) : name), image, 95);
    ++n_;
  }
  void walls(int n, int width = 640, int height = 480) {
    for (int i = 0; i < n; ++i) add(wall(width, height, 1, 20 * i));
  }
  nlohmann::json report(const std::map<std::string, fs::path>& more = {}) const {
    std::map<std::string, fs::path> inputs = more;
    inputs["photos"] = folder_.path();
    RecordingContext context(inputs);
    const Stage stage = inspect_stage();
    stage.run(context);
    return nlohmann::json::parse(read_file(context.output() / "inspect" / "report.json"));
  }
  fs::path path(const std::string& name) const { return folder_.path() / name; }

 private:
  TemporaryFolder folder_;
  int n_ = 0;
};

std::set<std::string> codes(const nlohmann::json& report) {
  std::set<std::string> all;
  for (const auto& f : report["findings"]) all.insert(f["code"]);
  return all;
}
std::vector<std::string> photos_of(const nlohmann::json& report, const std::string& code) {
  for (const auto& f : report["findings"])
    if (f["code"] == code) return f["photos"];
  return {};
}
using Names = std::vector<std::string>;

TEST(Inspect, FindsNothingWrongWithAGoodSet) {
  Folder folder;
  folder.walls(16, 960, 720);
  const auto report = folder.report();
  EXPECT_EQ(report["verdict"], "good") << report["findings"].dump(1);
  EXPECT_EQ(report["photos"].size(), 16u);
}

TEST(Inspect, NamesThePhotosThatAreWrong) {
  Folder folder;
  folder.walls(16);
  folder.add(smeared(wall(640, 480, 1, 330), 4, 0), "16.jpg");
  folder.add(wall(640, 480, 1, 340, 0.3), "17.jpg");
  folder.add(wall(640, 480, 1, 360), "18.jpg");
  folder.add(wall(640, 480, 1, 360), "19.jpg");
  write_file(folder.path("20.jpg"), read_file(folder.path("00.jpg")).substr(0, 2000));
  const auto report = folder.report();
  EXPECT_EQ(report["verdict"], "poor");
  EXPECT_EQ(photos_of(report, "soft_photos"), (Names{"16.jpg"}));
  EXPECT_EQ(photos_of(report, "mixed_exposure"), (Names{"17.jpg"}));
  EXPECT_EQ(photos_of(report, "near_duplicates"), (Names{"19.jpg"}));
  EXPECT_EQ(photos_of(report, "unreadable_photos"), (Names{"20.jpg"}));
  EXPECT_EQ(codes(report),
            (std::set<std::string>{"soft_photos", "mixed_exposure", "near_duplicates", "unreadable_photos", "small_photos"}));
}

TEST(Inspect, SaysWhatLiesBesideThePhotos) {
  Folder folder;
  folder.walls(16, 960, 720);
  Image8 mask(960, 720, 1);
  for (int y = 200; y < 500; ++y)
    for (int x = 300; x < 600; ++x) mask.at(x, y) = 255;
  folder.add(mask, "00_mask.png");
  fs::create_symlink("nowhere.jpg", folder.path("gone.jpg"));
  write_file(folder.path("a.webp"), "x");
  const auto report = folder.report();
  EXPECT_EQ(report["photos"].size(), 16u);
  EXPECT_EQ(codes(report), (std::set<std::string>{"masks_beside_photos", "links_broken", "types_not_read"}));
  for (const auto& f : report["findings"]) {
    if (f["code"] == "masks_beside_photos") {
      EXPECT_EQ(f["what"], "1 file is a mask of another file");
      EXPECT_EQ(f["why"], "00_mask.png of 00.jpg");
      EXPECT_NE(f["try"].get<std::string>().find("--masks "), std::string::npos);
    }
  }
}

TEST(Inspect, ChecksEveryDepthMap) {
  Folder folder;
  folder.walls(12);
  const TemporaryFolder maps;
  Image16 depth(320, 240, 1);
  for (size_t i = 0; i < depth.data().size(); ++i) depth.data()[i] = i % 4 == 0 ? uint16_t(0) : uint16_t(1500 + i % 1000);
  for (int i = 1; i < 12; ++i) write_png16(maps.path() / fmt::format("{:02}.png", i), depth);
  const auto of = [](const nlohmann::json& report, const std::string& code) {
    for (const auto& f : report["findings"])
      if (f["code"] == code) return f;
    return nlohmann::json();
  };
  const auto good = folder.report({{"depth", maps.path()}});
  EXPECT_EQ(of(good, "depth_maps")["what"], "11 of 12 photos have a depth map");
  EXPECT_EQ(of(good, "depth_maps")["why"], "75 % of the pixels are known, 1.5 to 2.5 m");
  EXPECT_EQ(photos_of(good, "DEPTH_INCOMPLETE"), (Names{"00.jpg"}));
  write_png16(maps.path() / "05.png", Image16(300, 300, 1, 7));
  EXPECT_EQ(of(folder.report({{"depth", maps.path()}}), "NOT_A_DEPTH_MAP")["severity"], "problem");  // of one depth
  Image16 square(300, 300, 1, 700);
  square.at(3, 3) = 900;
  write_png16(maps.path() / "05.png", square);
  EXPECT_EQ(photos_of(folder.report({{"depth", maps.path()}}), "DEPTH_OTHER_SHAPE"), (Names{"05.jpg"}));
}

TEST(Inspect, SeesCamerasAndZoomInExif) {
  Folder folder;
  folder.walls(16, 960, 720);
  for (int i = 0; i < 16; ++i) {
    const unsigned mm = i == 15 ? 50 : 28;
    const std::string model = i < 12 ? "Model A" : "Model B";
    test::add_exif(folder.path(fmt::format("{:02}.jpg", i)), test::exif_bytes({{0x110, 'a', 0, 1, model}}, {{0xa405, 's', mm}}));
  }
  const auto report = folder.report();
  EXPECT_EQ(codes(report), (std::set<std::string>{"mixed_cameras", "mixed_focal"}));
}

TEST(Inspect, NamesGpsCoordinates) {
  constexpr double kMetre = 1 / 111000.0;  // in degrees of latitude
  const auto why = [](size_t tagged, double spacing_m) {
    Folder folder;
    folder.walls(16, 320, 240);
    for (size_t i = 0; i < tagged; ++i)
      test::add_exif(folder.path(fmt::format("{:02}.jpg", i)),
                     test::exif_with_gps(test::place_tags(47 + kMetre * spacing_m * double(i), 8, 430)));
    const auto report = folder.report();
    for (const auto& f : report["findings"])
      if (f["code"] == "gps_positions") {
        EXPECT_EQ(f["severity"], "note");
        EXPECT_EQ(f["what"], fmt::format("{} of 16 photos have GPS coordinates", tagged));
        return f["why"].get<std::string>();
      }
    return std::string();
  };
  EXPECT_EQ(why(0, 5), "");
  EXPECT_EQ(why(3, 5), "fewer than 4 give no scale");
  EXPECT_EQ(why(16, 5), "they spread over 23.1 m: scale and north come from them, if they agree with the poses");
  EXPECT_EQ(why(16, 0.5), "they spread over 2.3 m, too little for a scale at the usual error of 1.7 m");
}

TEST(Inspect, SeesAZoomInMillimetresAndADigitalOne) {
  for (const bool digital : {false, true}) {
    Folder folder;
    folder.walls(16, 960, 720);
    for (int i = 0; i < 16; ++i) {
      const unsigned times = i % 2 ? 2 : 1;
      const std::string exif = digital ? test::exif_bytes({}, {{0x920a, 'r', 24, 1}, {0xa404, 'r', times, 1}, {0xa405, 's', 28}})
                                       : test::exif_bytes({}, {{0x920a, 'r', 24 * times, 1}});
      test::add_exif(folder.path(fmt::format("{:02}.jpg", i)), exif);
    }
    EXPECT_EQ(codes(folder.report()), std::set<std::string>{"mixed_focal"}) << digital;
  }
}

TEST(Inspect, NamesColourProfilesAndAlpha) {
  Folder folder;
  folder.walls(16, 960, 720);
  const auto say = [&](int photo, unsigned color_space) {
    test::add_exif(folder.path(fmt::format("{:02}.jpg", photo)), test::exif_bytes({}, {{0xa001, 's', color_space}}));
  };
  constexpr unsigned kSrgb = 1, kAdobeRgb = 2, kUncalibrated = 0xffff;
  say(3, kSrgb), say(4, kAdobeRgb), say(5, kAdobeRgb), say(6, kUncalibrated);
  Image8 cut_out(960, 720, 4, 255);
  const Image8 wall_16 = wall(960, 720, 1, 320);
  for (int y = 0; y < 720; ++y)
    for (int x = 0; x < 960; ++x) {
      for (int c = 0; c < 3; ++c) cut_out.at(x, y, c) = wall_16.at(x, y, c);
      cut_out.at(x, y, 3) = x < 300 ? 0 : 255;
    }
  write_file(folder.path("16.tif"), test::tagged_tiff(cut_out, ""));
  const auto report = folder.report();
  EXPECT_EQ(codes(report), (std::set<std::string>{"mixed_profiles", "color_profiles", "unusable_profiles", "alpha_not_used"}))
      << report["findings"].dump(1);
  EXPECT_EQ(photos_of(report, "unusable_profiles"), (Names{"06.jpg"}));
  EXPECT_EQ(photos_of(report, "alpha_not_used"), (Names{"16.tif"}));
  EXPECT_EQ(report["photos"][4]["color_profile"], "Adobe RGB (1998)");
  EXPECT_EQ(report["photos"][4]["color_source"], "exif ColorSpace");
  for (const auto& f : report["findings"]) {
    if (f["code"] != "color_profiles") continue;
    EXPECT_EQ(f["what"], "2 photos Adobe RGB (1998) -> linear Rec. 709");
  }
}

TEST(Inspect, SaysThatAWallIsBare) {
  Folder folder;
  for (int i = 0; i < 16; ++i) {
    Image8 image(960, 720, 3);
    for (int y = 0; y < 720; ++y)
      for (int x = 0; x < 960; ++x)
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = uint8_t(60 + (x + 20 * i) / 12 + y / 15);
    folder.add(image);
  }
  EXPECT_TRUE(codes(folder.report()).contains("low_texture"));
}

TEST(Inspect, RefusesAFolderWithoutAReadablePhoto) {
  TemporaryFolder folder;
  write_file(folder.path() / "a.jpg", "no picture");
  RecordingContext context({{"photos", folder.path()}});
  const Stage stage = inspect_stage();
  const Error e = error_of([&] { stage.run(context); });
  EXPECT_EQ(exit_code(e.kind()), 3);
  EXPECT_EQ(e.detail().code, "NO_PHOTOS");
}

// --- coverage ---------------------------------------------------------------------------------------------------------------

// Cameras at these azimuths on a circle around `centre`, looking at it (or away from it).
ViewSet ring(const std::vector<double>& azimuths_deg, double elevation_deg, const Vec3d& centre, bool inward = true) {
  ViewSet set;
  for (double azimuth : azimuths_deg) {
    const double a = azimuth * std::numbers::pi / 180, e = elevation_deg * std::numbers::pi / 180;
    const Vec3d out{std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
    const Vec3d forward = inward ? -out : out, right = normalized(cross(forward, {0, 0, 1}));
    View v;
    v.name = fmt::format("{:.0f}.jpg", azimuth);
    v.cam_from_world = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, centre + 2.0 * out});
    set.views.push_back(v);
  }
  return set;
}

TEST(Coverage, FindsTheHoleInARing) {
  std::vector<double> azimuths;
  for (double a = 0; a < 360; a += 12)
    if (a <= 200 || a >= 260) azimuths.push_back(a);
  const Coverage c = coverage(ring(azimuths, 20, {0.3, -0.2, 0.1}));
  EXPECT_TRUE(c.inward);
  EXPECT_NEAR(length(c.centre - Vec3d{0.3, -0.2, 0.1}), 0, 1e-9);
  ASSERT_EQ(c.gaps.size(), 1u);
  EXPECT_NEAR(c.gaps[0].width_deg(), 72, 1e-6);
  EXPECT_EQ(c.gaps[0].from, "192.jpg");
  EXPECT_EQ(c.gaps[0].to, "264.jpg");
  EXPECT_EQ(c.gaps[0].photos_to_add, 4u);
  EXPECT_NEAR(c.lowest_deg, 20, 1e-6);
}

TEST(Coverage, ClosesTheRingAcrossNorthAndLeavesOutwardViewsAlone) {
  const Coverage half = coverage(ring({300, 315, 330, 345, 0, 15, 30}, 0, {}));
  ASSERT_EQ(half.gaps.size(), 1u);
  EXPECT_NEAR(half.gaps[0].width_deg(), 270, 1e-6);
  const Coverage room = coverage(ring({0, 60, 120, 180, 240, 300}, 5, {}, false));
  EXPECT_FALSE(room.inward);
  EXPECT_TRUE(room.gaps.empty());
}

}  // namespace
}  // namespace vitrine
