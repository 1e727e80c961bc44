// What other people's programs say about exported files: the Khronos validator, three.js and Spark in headless Chromium,
// splat-transform.
// Label `external`: needs node, npm, chromium and the network (npm install, once per build folder).
#include <algorithm>
#include <cstdio>
#include <sstream>

#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/scene/image/ldr.h"
#include "core/foundation/math/color.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/raster/renderer.h"
#include "core/scene/camera/colmap_model.h"
#include "stages/export/export.h"
#include "stages/export/formats/gaussian_ply.h"
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
    const test::PaneScene scene;
    scene.write(root.path());
    context_ = new test::RecordingContext(
        {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
    run_export({.formats = {"mesh-glb", "ply-3dgs"}, .texture_size = 512}, *context_);
    DecomposedMaterials materials;
    materials.resize(scene.diffuse.size());
    for (size_t i = 0; i < materials.size(); ++i) materials.albedo[i] = albedo(i), materials.roughness[i] = kRoughness;
    write_decomposed_materials(root.path() / "decompose", materials);
    albedo_ = new test::RecordingContext({{"sfm", root.path() / "sfm"},
                                          {"optimize", root.path() / "optimize"},
                                          {"mesh", root.path() / "mesh"},
                                          {"decompose", root.path() / "decompose"}});
    run_export({.formats = {"ply-albedo"}}, *albedo_);
  }
  static void TearDownTestSuite() { delete context_, delete albedo_; }
  void SetUp() override { ASSERT_EQ(installed_.code, 0) << "npm install: " << installed_.out; }

  static std::string exported(const char* file) { return (context_->output() / "export" / file).string(); }

  static std::string with_albedo() { return (albedo_->output() / "export/gaussians_albedo.ply").string(); }
  // Stripes, unlike the trained colours.
  static Vec3f albedo(size_t surfel) { return surfel / 200 % 2 == 0 ? Vec3f{0.1f, 0.6f, 0.2f} : Vec3f{0.7f, 0.7f, 0.1f}; }
  static constexpr float kRoughness = 0.375f;

  static inline Said installed_;
  static inline test::RecordingContext *context_ = nullptr, *albedo_ = nullptr;
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
  const std::string columns = csv.substr(0, csv.find('\n'));
  EXPECT_NE(columns.find("f_dc_0"), std::string::npos);
  EXPECT_NE(columns.find("f_rest_44"), std::string::npos) << "padded to degree 3";
}

// Its reader of SPZ is that of the authors of the format. It keeps the order and turns y up into the axes of PLY files.
TEST_F(External, SplatTransformReadsTheSpz) {
  const TemporaryFolder root;
  const test::PaneScene scene;
  scene.write(root.path());
  ColmapModel cameras;
  for (uint32_t i = 1; i <= 3; ++i) {
    cameras.cameras.push_back(colmap_pinhole(i, {48, 36, 45, 45, 24, 18}));
    cameras.images.push_back({i, {0, 1, 0, 0}, {0.1 * i, 0, 2}, i, fmt::format("{}.jpg", i), {}});
  }
  make_folders(root.path() / "sfm/sparse/0");
  write_colmap_model(root.path() / "sfm/sparse/0", cameras, ColmapFormat::Binary);
  test::RecordingContext c(
      {{"sfm", root.path() / "sfm"}, {"optimize", root.path() / "optimize"}, {"mesh", root.path() / "mesh"}});
  run_export({.formats = {"gaussians-spz"}}, c);
  const Said said = run_external({"npx", "splat-transform", "-w", (c.output() / "export/gaussians.spz").string(), "spz.csv"});
  ASSERT_EQ(said.code, 0) << said.out;
  std::istringstream csv(read_file(fs::path(EXTERNAL_DIR) / "spz.csv"));
  std::string names, line;
  std::getline(csv, names);
  EXPECT_TRUE(names.starts_with("x,y,z,")) << names;
  for (size_t i = 0; i < scene.diffuse.size(); ++i) {
    ASSERT_TRUE(std::getline(csv, line));
    double p[3];
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf", p, p + 1, p + 2), 3) << line;
    const float* mean = scene.diffuse.at(Attribute::Mean, i);
    const double wanted[] = {mean[0], -mean[2], mean[1]};  // x, -y, -z of the y-up file
    for (size_t k = 0; k < 3; ++k) ASSERT_NEAR(p[k], wanted[k], 1e-5) << line;
  }
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

// PSNR of Spark's picture of the file against ours of the layer; a grey picture would have `blind`. Both are kept to look at.
struct SplatPicture {
  double psnr, blind;
};
void compare_with_spark(const std::string& file, const SplatLayer& layer, const std::string& name, SplatPicture& out) {
  View view;
  view.intrinsics = {320, 240, 280, 280, 160, 120};
  const Vec3d eye{1.6, -2.0, 1.4}, forward = normalized(Vec3d{0, 0, 0.25} - eye),
                                   right = normalized(cross(forward, Vec3d{0, 0, 1}));
  const Rigid world_from_cam{Mat3d{right, cross(forward, right), forward}, eye};
  view.cam_from_world = inverse(world_from_cam);
  const ImageF ours = display_picture(layer, view);
  const fs::path folder = EXTERNAL_DIR;
  Image8 shown(ours.width(), ours.height(), 3);
  for (size_t i = 0; i < shown.data().size(); ++i) shown.data()[i] = uint8_t(std::lround(255 * ours.data()[i]));
  write_ldr(folder / (name + "_ours.png"), shown);
  json camera{{"width", 320}, {"height", 240}, {"fx", 280}, {"fy", 280}, {"world_from_cam", json::array()}};
  for (size_t r = 0; r < 3; ++r) {
    for (size_t c = 0; c < 3; ++c) camera["world_from_cam"].push_back(world_from_cam.rotation(r, c));
    camera["world_from_cam"].push_back(world_from_cam.translation[r]);
  }
  write_file(folder / "splats_camera.json", camera.dump());
  const Said said = run_external({"node", "splats.mjs", file, "splats_camera.json", name + ".png"});
  ASSERT_EQ(said.code, 0) << said.out;
  const ImageF theirs = read_srgb(folder / (name + ".png"));
  ASSERT_EQ(theirs.data().size(), ours.data().size());
  double square = 0, flat = 0, mean = 0;
  for (float v : ours.data()) mean += double(v) / double(ours.data().size());
  for (size_t i = 0; i < ours.data().size(); ++i) {
    square += std::pow(double(ours.data()[i]) - double(theirs.data()[i]), 2) / double(ours.data().size());
    flat += std::pow(double(ours.data()[i]) - mean, 2) / double(ours.data().size());
  }
  out = {-10 * std::log10(square), -10 * std::log10(flat)};
}

TEST_F(External, SparkShowsTheGaussiansAsWeDo) {
  SplatPicture p{};
  ASSERT_NO_FATAL_FAILURE(compare_with_spark(exported("gaussians_3dgs.ply"), test::PaneScene().diffuse, "splats", p));
  RecordProperty("psnr", std::to_string(p.psnr));
  EXPECT_GT(p.psnr, 30) << "a grey picture would have " << p.blind;  // seen: 36.0
  EXPECT_GT(p.psnr, p.blind + 8);
}

TEST_F(External, SparkShowsTheAlbedo) {
  SplatLayer layer = test::PaneScene().diffuse;
  for (size_t i = 0; i < layer.size(); ++i)
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::ShDc, i)[c] = (albedo(i)[c] - 0.5f) / kShDc;
  SplatPicture p{};
  ASSERT_NO_FATAL_FAILURE(compare_with_spark(with_albedo(), layer, "albedo", p));
  RecordProperty("psnr", std::to_string(p.psnr));
  EXPECT_GT(p.psnr, 30) << "a grey picture would have " << p.blind;
  EXPECT_GT(p.psnr, p.blind + 8);
}

// PlayCanvas' splat-transform keeps the columns of the materials; three's own reader of PLY files finds them by name.
TEST_F(External, OthersReadTheMaterialsOfTheAlbedoPly) {
  const Said said = run_external({"npx", "splat-transform", "-w", with_albedo(), "albedo.csv"});
  ASSERT_EQ(said.code, 0) << said.out;
  const std::string csv = read_file(fs::path(EXTERNAL_DIR) / "albedo.csv"), columns = csv.substr(0, csv.find('\n'));
  for (const char* name : {"nx", "f_dc_0", "roughness", "f0_r", "specular_weight", "transmission"})
    EXPECT_NE(columns.find(name), std::string::npos) << columns;
  EXPECT_EQ(columns.find("f_rest"), std::string::npos);
  const Said three = run_external({"node", "ply.mjs", with_albedo()});
  ASSERT_EQ(three.code, 0) << three.out;
  const json r = json::parse(three.out);
  EXPECT_EQ(r["vertices"], test::PaneScene().diffuse.size());
  EXPECT_EQ(r["roughness"], kRoughness);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(r["normal"][c].get<float>(), c == 2 ? 1 : 0, 1e-5);
    EXPECT_NEAR(0.5f + kShDc * r["f_dc"][c].get<float>(), srgb_from_linear(albedo(0)[c]), 1e-5);
  }
}

}  // namespace
}  // namespace vitrine
