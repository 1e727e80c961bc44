// `vitrine ct`: a small scan as 16-bit pictures with flat and dark fields, and what is refused.
#include <cstdlib>

#include <gtest/gtest.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "pipeline/commands.h"
#include "stages/tomography/scan_file.h"
#include "tests/stages/tomography/phantoms.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

constexpr const char* kCone =
    "beam: cone\nsource_distance: 6\ndetector_distance: 9\npixel_size: 0.1375\nunit: cm\nangles: {first: 0, step: 30}\n";

class CtCommand : public testing::Test {
 protected:
  CtCommand() {
    make_folders(at("views"));
    const ScanGeometry g = test::cone_scan(12, 24);
    const std::vector<ImageF> projections = test::scanned(g, {{{.6, .5, .7}, {0, 0, 0}, 20, .8}});
    for (size_t i = 0; i < projections.size(); ++i) {
      Image16 picture(24, 24, 1);
      for (size_t p = 0; p < picture.pixel_count(); ++p)
        picture.data()[p] = uint16_t(std::lround(3000 + 50000 * std::exp(-double(projections[i].data()[p]))));
      write_png16(at("views") / fmt::format("view_{:03d}.png", i), picture);
    }
    level("flat.png", 53000), level("dark.png", 3000);
  }
  fs::path at(const std::string& name) const { return folder_.path() / name; }
  void level(const std::string& name, int value) const { write_png16(at(name), Image16(24, 24, 1, uint16_t(value))); }
  fs::path scan(const std::string& text) const {
    write_file(at("scan.yaml"), text);
    return at("scan.yaml");
  }
  static std::string usual() { return std::string(kCone) + "projections: views\nflat: flat.png\ndark: dark.png\n"; }
  int ct(const fs::path& file) const {
    return ct_command({file.string(), "-o", at("out").string(), "--quiet", "--no-progress", "--set", "voxels=14"});
  }
  std::string ct_command_error(const fs::path& out) const {
    return error_of([&] { ct_command({at("scan.yaml").string(), "-o", out.string()}); }).message();
  }
  // Error of reading the scan, its pictures included.
  std::string refusal(const std::string& text) const {
    const fs::path file = scan(text);
    return error_of([&] {
             ScanFile s = read_scan(file);
             read_projections(s);
           })
        .what();
  }

  TemporaryFolder folder_;
};

TEST_F(CtCommand, WritesVolumeSurfaceSlicesAndReport) {
  ASSERT_EQ(ct(scan(usual())), 0);
  const auto report = nlohmann::json::parse(read_file(at("out/ct/report.json")));
  EXPECT_LT(report["residual"]["of_projections"].get<double>(), 0.1);
  EXPECT_EQ(report["unit"], "cm");
  for (const char* file : {"volume.nrrd", "surface.ply", "slices/slice_0000.exr", "middle_x.png", "middle_y.png", "middle_z.png"})
    EXPECT_TRUE(fs::exists(at("out/ct") / file)) << file;
  const ImageF middle = read_exr(at("out/ct/slices") / fmt::format("slice_{:04d}.exr", report["size"][2].get<int>() / 2)).pixels;
  EXPECT_NEAR(double(middle.at(middle.width() / 2, middle.height() / 2)), 0.8, 0.1);
  ASSERT_EQ(ct(scan(usual())), 0) << "again, from the store";
}

TEST_F(CtCommand, AnInterruptedScanGoesOnInItsFolder) {
  make_folders(at("out/.cache/tomography/key.scratch"));
  EXPECT_EQ(ct(scan(usual())), 0);
  EXPECT_TRUE(fs::exists(at("out/ct/volume.nrrd")));
  make_folders(at("other/.cache/optimize"));
  EXPECT_EQ(ct_command_error(at("other")), "the output folder contains other files");
}

TEST_F(CtCommand, MistakesAreErrorsAndLeaveNothing) {
  EXPECT_EQ(ct(scan(std::string(kCone) + "projections: views\nflat: dark.png\ndark: flat.png\n")), exit_code(ErrorKind::Input));
  EXPECT_FALSE(fs::exists(at("out")));
  EXPECT_EQ(ct(scan("beam: fan\n")), exit_code(ErrorKind::Usage));
  EXPECT_FALSE(fs::exists(at("out")));
}

TEST_F(CtCommand, MistakesInTheFileAreNamed) {
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string text = usual();
    return text.replace(text.find(from), from.size(), to);
  };
  EXPECT_EQ(read_scan(scan(usual())).geometry.angles.size(), 12u);
  const std::pair<std::string, const char*> cases[] = {
      {changed("projections: views", "projections: nowhere"), "there is no folder"},
      {changed("{first: 0, step: 30}", "[0, 30, 60]"), "3 angles, but 12 projections"},
      {changed("{first: 0, step: 30}", "{first: 0, step: 360}"), "three different angles"},
      {changed("detector_distance: 9", "detector_distance: 5"), "the detector lies before the axis"},
      {changed("pixel_size: 0.1375", "pixel_size: 0"), "pixel_size must be more than 0"},
      {changed("flat: flat.png", "flat: none.png"), "there is no file"},
      {changed("flat: flat.png\n", ""), "either flat"},
      {changed("beam: cone", "beam: parallel"), "a parallel beam has no source_distance"},
      {changed("unit: cm", "unit: inch"), "unit must be"},
      {changed("unit: cm", "speed: 3"), "speed"},
  };
  for (const auto& [text, why] : cases) EXPECT_NE(refusal(text).find(why), std::string::npos) << why << "\n" << refusal(text);
}

TEST_F(CtCommand, MistakesInThePicturesAreNamed) {
  EXPECT_NE(refusal(std::string(kCone) + "projections: views\nflat: dark.png\ndark: flat.png\n").find("not brighter"),
            std::string::npos);
  write_png16(at("flat.png"), Image16(20, 24, 1, 53000));
  EXPECT_NE(refusal(usual()).find("different sizes"), std::string::npos);
  level("flat.png", 53000);
  for (int i = 0; i < 12; ++i) level(fmt::format("views/view_{:03d}.png", i), 53000);
  EXPECT_NE(refusal(usual()).find("show nothing"), std::string::npos);
  write_file(at("views/view_003.png"), "no picture");
  EXPECT_NE(refusal(usual()).find("view_003.png"), std::string::npos);
}

TEST_F(CtCommand, TheSourceStandsOutsideTheVolume) {
  std::string text = usual();
  const std::string size = "pixel_size: 0.1375";
  text.replace(text.find(size), size.size(), "pixel_size: 14");
  EXPECT_EQ(ct(scan(text)), exit_code(ErrorKind::Input));
}

}  // namespace
}  // namespace vitrine
