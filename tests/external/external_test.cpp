// What other people's programs say about exported files: the Khronos validator, three.js and Spark in headless Chromium,
// splat-transform.
// Label `external`: needs node, npm, chromium and the network (npm install, once per build folder).
#include <algorithm>

#include <gtest/gtest.h>

#include "core/base/json.h"
#include "core/image/ldr.h"
#include "core/render/renderer.h"
#include "stages/export/export.h"
#include "stages/export/formats/display_color.h"
#include "tests/external/programs.h"
#include "tests/stages/export/pane_scene.h"
#include "tests/stages/export/solid_ball.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using nlohmann::json;

class External : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    installed_ = install();
    const TemporaryFolder root;
    test::PaneScene().write(root.path());
    context_ = new test::RecordingContext(
        {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
    run_export({.formats = {"mesh-glb", "ply-3dgs"}, .texture_size = 512}, *context_);
  }
  static void TearDownTestSuite() { delete context_; }
  void SetUp() override { ASSERT_EQ(installed_.code, 0) << "npm install: " << installed_.out; }

  static std::string exported(const char* file) { return (context_->output() / "export" / file).string(); }

  static inline Said installed_;
  static inline test::RecordingContext* context_ = nullptr;
};

TEST_F(External, TheKhronosValidatorFindsNoErrorInTheGlb) {
  const Said said = run_external({"node", "validate.mjs", exported("mesh.glb")});
  EXPECT_EQ(said.code, 0) << said.out;
  const json report = json::parse(said.out.substr(0, said.out.find('\n')));
  EXPECT_EQ(report["errors"], 0);
  EXPECT_EQ(report["warnings"], 0) << said.out;
}

TEST_F(External, ThreeJsShowsTheFloorThroughThePane) {
  const Said said = run_external({"node", "render.mjs", exported("mesh.glb"), "pane.png", "-20", "15"});
  ASSERT_EQ(said.code, 0) << said.out;
  const json r = json::parse(said.out.substr(said.out.find('{')));
  EXPECT_GT(r["glass"], 0.03) << "the pane is in the picture";
  EXPECT_GT(r["inside"], 20) << "its pixels change when it stops transmitting";  // 73 on the cabinet
  EXPECT_LT(r["outside"], 0.5) << "and no others do";
  EXPECT_GT(r["spread"][0], 2 * r["spread"][1].get<double>()) << "tiles are seen through it, not a plain sheet";
}

TEST_F(External, SolidGlassIsValidAndThreeJsBendsWhatIsSeenThroughIt) {
  const TemporaryFolder root;
  test::SolidBallScene().write(root.path());
  test::RecordingContext c(
      {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
  run_export({.formats = {"mesh-glb"}, .texture_size = 512}, c);
  const std::string file = (c.output() / "export/mesh.glb").string();
  const Said valid = run_external({"node", "validate.mjs", file});
  EXPECT_EQ(valid.code, 0) << valid.out;
  const json report = json::parse(valid.out.substr(0, valid.out.find('\n')));
  EXPECT_EQ(report["errors"], 0);
  EXPECT_EQ(report["warnings"], 0) << valid.out;
  EXPECT_TRUE(std::ranges::count(report["extensions"], "KHR_materials_volume")) << valid.out;
  const Said said = run_external({"node", "render.mjs", file, "solid.png", "20", "15"});
  ASSERT_EQ(said.code, 0) << said.out;
  const json r = json::parse(said.out.substr(said.out.find('{')));
  EXPECT_GT(r["bent"], 5) << said.out;
  EXPECT_LT(r["outside"], 0.5);
}

TEST_F(External, SplatTransformReadsThe3dgsPly) {
  const Said said = run_external({"npx", "splat-transform", "-w", exported("gaussians_3dgs.ply"), "splats.csv"});
  ASSERT_EQ(said.code, 0) << said.out;
  const std::string csv = read_file(fs::path(EXTERNAL_DIR) / "splats.csv");
  const size_t lines = size_t(std::count(csv.begin(), csv.end(), '\n'));
  const size_t surfels = test::PaneScene().diffuse.size();
  EXPECT_GE(lines, surfels);
  EXPECT_LE(lines, surfels + 1);
  EXPECT_NE(csv.substr(0, csv.find('\n')).find("f_dc_0"), std::string::npos);
}

// What viewers do: display values, blended as they are.
ImageF display_picture(SplatLayer layer, const View& view) {
  for (size_t i = 0; i < layer.size(); ++i) encode_sh_for_display({layer.at(Attribute::ShDc, i), 3});  // degree 0 is all there is
  RasterImages images;
  make_renderer(Backend::Cpu)
      ->forward(layer,
                {.intrinsics = view.intrinsics,
                 .cam_from_world = view.cam_from_world,
                 .features = FeatureSet::ColorOnly,
                 .sh_degree = 0},
                images);
  const auto color = images.plane(Aov::Color);
  ImageF out(view.intrinsics.width, view.intrinsics.height, 3);
  for (size_t p = 0; p < out.pixel_count(); ++p)
    for (size_t c = 0; c < 3; ++c) out.data()[3 * p + c] = std::clamp(color[c * out.pixel_count() + p], 0.f, 1.f);
  return out;
}

TEST_F(External, SparkShowsTheGaussiansAsWeDo) {
  View view;
  view.intrinsics = {320, 240, 280, 280, 160, 120};
  const Vec3d eye{1.6, -2.0, 1.4}, forward = normalized(Vec3d{0, 0, 0.25} - eye),
                                   right = normalized(cross(forward, Vec3d{0, 0, 1}));
  const Rigid world_from_cam{Mat3d{right, cross(forward, right), forward}, eye};
  view.cam_from_world = inverse(world_from_cam);
  const ImageF ours = display_picture(test::PaneScene().diffuse, view);
  const fs::path folder = EXTERNAL_DIR;
  Image8 shown(ours.width(), ours.height(), 3);
  for (size_t i = 0; i < shown.data().size(); ++i) shown.data()[i] = uint8_t(std::lround(255 * ours.data()[i]));
  write_ldr(folder / "splats_ours.png", shown);  // to look at, beside splats.png
  json camera{{"width", 320}, {"height", 240}, {"fx", 280}, {"fy", 280}, {"world_from_cam", json::array()}};
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) camera["world_from_cam"].push_back(world_from_cam.rotation(r, c));
    camera["world_from_cam"].push_back(world_from_cam.translation[r]);
  }
  write_file(folder / "splats_camera.json", camera.dump());
  const Said said = run_external({"node", "splats.mjs", exported("gaussians_3dgs.ply"), "splats_camera.json", "splats.png"});
  ASSERT_EQ(said.code, 0) << said.out;
  const ImageF theirs = read_srgb(folder / "splats.png");
  ASSERT_EQ(theirs.data().size(), ours.data().size());
  double square = 0, flat = 0, mean = 0;
  for (float v : ours.data()) mean += double(v) / double(ours.data().size());
  for (size_t i = 0; i < ours.data().size(); ++i) {
    square += std::pow(double(ours.data()[i]) - double(theirs.data()[i]), 2) / double(ours.data().size());
    flat += std::pow(double(ours.data()[i]) - mean, 2) / double(ours.data().size());
  }
  const double psnr = -10 * std::log10(square), blind = -10 * std::log10(flat);
  RecordProperty("psnr", std::to_string(psnr));
  EXPECT_GT(psnr, 30) << "a grey picture would have " << blind;  // seen: 36.0
  EXPECT_GT(psnr, blind + 8);
}

}  // namespace
}  // namespace vitrine
