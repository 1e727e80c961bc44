// The program behind `vitrine relight` on a ball whose materials are known.
#include "stages/relight/relight.h"

#include <gtest/gtest.h>

#include "core/foundation/math/color.h"
#include "core/render/picture/decomposed_materials.h"
#include "tests/core/render/relight/relit_ball.h"
#include "tests/support/error_of.h"
#include "tests/support/files_below.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

using test::RecordingContext;
using test::TinyCapture;

class RelightStage : public testing::Test {
 protected:
  RelightStage() {
    make_folders(decompose() / "decompose");
    write_decomposed_materials(decompose(), test::relit_ball({0.8f, 0.4f, 0.2f}).materials);
    write_environment(decomposed_environment_path(decompose()), Environment(ImageF(16, 8, 3, 1.f)));
    write_environment(folder.path() / "probe.exr", axis_probe(32));
  }
  fs::path decompose() const { return folder.path() / "artifact"; }
  fs::path probe() const { return folder.path() / "probe.exr"; }
  std::map<std::string, fs::path> inputs(std::map<std::string, fs::path> more = {}) const {
    more.insert({{"sfm", capture.sfm()}, {"optimize", capture.optimize()}, {"mesh", capture.mesh()}, {"decompose", decompose()}});
    return more;
  }
  Error error_with(std::map<std::string, fs::path> more, const RelightConfig& config = {.samples = 1}) const {
    RecordingContext context(inputs(std::move(more)));
    const Error e = error_of([&] { run_relight(config, context); });
    EXPECT_FALSE(fs::exists(context.output() / "relit")) << "nothing is written before everything is known to be good";
    return e;
  }

  TemporaryFolder folder;
  TinyCapture capture;
};

TEST_F(RelightStage, HeldOutViewsUnderANewLight) {
  RecordingContext context(inputs({{"env", probe()}}));
  run_relight({.samples = 4, .exposure = 1, .auto_exposure = false}, context);
  const fs::path out = context.output() / "relit" / "probe";
  for (const char* file : {"view_0.png", "view_0.exr", "contact_sheet.png", "transforms.json", "settings.json"})
    EXPECT_TRUE(fs::exists(out / file)) << file;
  const ImageF linear = read_exr_rgb(out / "view_0.exr"), srgb = read_srgb(out / "view_0.png");
  ASSERT_EQ(linear.width(), TinyCapture::kWidth);
  // The PNG is one stop brighter, clipped and encoded; the corner shows the cyan of -x behind the ball.
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(srgb.at(40, 24, c), srgb_from_linear(std::clamp(2 * linear.at(40, 24, c), 0.f, 1.f)), 0.004);
  }
  EXPECT_GT(linear.at(1, 1, 1), 0.2);
  EXPECT_EQ(linear.at(1, 1, 1), linear.at(1, 1, 2));
  EXPECT_LT(linear.at(1, 1, 0), 0.05);
  EXPECT_EQ(context.metrics.at("views"), 1);
}

TEST_F(RelightStage, WithoutALightTheOneOfThePhotosShines) {
  RecordingContext context(inputs());
  run_relight({.width = 32, .height = 24, .samples = 16}, context);
  const ImageF picture = read_exr_rgb(context.output() / "relit/captured/view_0.exr");
  ASSERT_EQ(picture.width(), 32);
  EXPECT_NEAR(picture.at(16, 12, 0), 0.8, 0.03);  // constant light of 1: the albedo
  EXPECT_NEAR(picture.at(16, 12, 2), 0.2, 0.03);
}

TEST_F(RelightStage, PicturesAreDevelopedToMiddleGreyWhateverTheUnitsOfTheMap) {
  std::vector<ImageF> pictures;
  for (const float radiance : {0.02f, 50.f}) {
    write_environment(folder.path() / "white.exr", Environment(ImageF(16, 8, 3, radiance)));
    RecordingContext context(inputs({{"env", folder.path() / "white.exr"}}));
    run_relight({.width = 32, .height = 24, .samples = 16}, context);
    pictures.push_back(read_srgb(context.output() / "relit/white/view_0.png"));
  }
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(pictures[0].at(16, 12, c), pictures[1].at(16, 12, c), 0.03);
  // The ball's albedo 0.8 0.4 0.2 has the luminance 0.47; it becomes 0.18.
  EXPECT_NEAR(linear_from_srgb(pictures[0].at(16, 12, 1)), 0.4 / 0.47 * 0.18, 0.02);
}

TEST_F(RelightStage, RotationTurnsTheLight) {
  const auto corner = [&](double degrees) {
    RecordingContext context(inputs({{"env", probe()}}));
    run_relight({.width = 32, .height = 24, .samples = 4, .rotate = degrees}, context);
    return read_exr_rgb(context.output() / "relit/probe/view_0.exr");
  };
  const ImageF at_0 = corner(0), at_360 = corner(360), at_90 = corner(90);
  EXPECT_EQ(at_0, at_360);
  // The corner looks past the ball towards -x, where the probe is cyan. Counter-clockwise seen from above +y comes to lie there,
  // which is green; the other sense would bring the magenta of -y.
  for (int c = 1; c < 3; ++c) EXPECT_GT(at_0.at(1, 1, c), 3 * at_0.at(1, 1, 0));
  for (int c = 0; c < 3; c += 2) EXPECT_GT(at_90.at(1, 1, 1), 3 * at_90.at(1, 1, c));
}

TEST_F(RelightStage, AnEnvironmentAndLampsTogetherHaveAFolderOfTheirOwn) {
  write_file(folder.path() / "lamps.yaml", "lights:\n  - {type: point, position: [1, 0, 0.2], intensity: 1}\n");
  RecordingContext context(inputs({{"env", probe()}, {"lights", folder.path() / "lamps.yaml"}}));
  run_relight({.width = 16, .height = 12, .samples = 1}, context);
  EXPECT_TRUE(fs::exists(context.output() / "relit/probe_lamps/view_0.png"));
  EXPECT_FALSE(fs::exists(context.output() / "relit/probe"));
}

TEST_F(RelightStage, MissingViewsAreCalledByTheirName) {
  capture.write_split({}, {1, 2});
  const Error heldout = error_with({});
  EXPECT_EQ(heldout.detail().code, "NO_VIEWS");
  EXPECT_NE(std::string(heldout.what()).find("no held-out views"), std::string::npos) << heldout.what();
  EXPECT_EQ(heldout.detail().hint, "--views all");
  capture.write_split({1, 2}, {});
  const Error train = error_with({}, {.views = ViewChoice::Train, .samples = 1});
  EXPECT_NE(std::string(train.what()).find("no training views"), std::string::npos) << train.what();
}

TEST_F(RelightStage, ATurntableGoesAroundWhatThePhotosLookAt) {
  EXPECT_LT(length(point_looked_at(capture.views)), 1e-6);
  const std::vector<View> views = turntable_views(capture.views, 8);
  ASSERT_EQ(views.size(), 8u);
  for (const View& v : views) {
    const Vec3d c = v.centre_in_world();
    EXPECT_NEAR(std::hypot(c.x, c.y), 1, 1e-6);
    EXPECT_NEAR(c.z, 0.4, 0.06);
    EXPECT_LT(length(normalized(v.cam_from_world * Vec3d{}) - Vec3d{0, 0, 1}), 1e-9);  // the target lies on the axis
  }
  const Vec3d start = views[0].centre_in_world(), opposite = views[4].centre_in_world();  // wherever it starts
  EXPECT_LT(start.x * opposite.x + start.y * opposite.y, -0.9);
  // Photos of one side: the camera stays on it.
  const std::vector<View> half(capture.views.begin(), capture.views.begin() + 4);
  for (const View& v : turntable_views(half, 8)) EXPECT_GT(v.centre_in_world().y, -1e-6);
  RecordingContext context(inputs({{"env", probe()}}));
  run_relight({.turntable = 3, .width = 16, .height = 12, .samples = 1}, context);
  EXPECT_TRUE(fs::exists(context.output() / "relit/probe/frame_0002.png"));
}

TEST_F(RelightStage, PartsOfATurntableAreTheFramesOfTheWhole) {
  const auto files_of = [&](const std::string& frames) {
    RecordingContext context(inputs({{"env", probe()}}));
    run_relight({.turntable = 5, .width = 16, .height = 12, .samples = 2, .frames = frames}, context);
    return test::files_below(context.output());
  };
  const auto first = files_of("0-1"), last = files_of("2-4");
  auto whole = files_of("");
  for (const char* of_all : {"relit/probe/contact_sheet.png", "relit/probe/turntable.mp4"}) whole.erase(of_all);
  EXPECT_TRUE(last.contains("relit/probe/frame_0004.exr"));
  EXPECT_FALSE(first.contains("relit/probe/frame_0002.png"));
  auto both = first;
  both.insert(last.begin(), last.end());
  EXPECT_EQ(both, whole);
  for (const char* shared : {"relit/probe/transforms.json", "relit/probe/settings.json"})
    EXPECT_EQ(first.at(shared), last.at(shared)) << "no clash in one folder";
  EXPECT_EQ(error_with({}, {.turntable = 5, .samples = 1, .frames = "3-5"}).detail().code, "NO_FRAME");
}

TEST_F(RelightStage, LampsAloneLightTheScene) {
  write_file(folder.path() / "lamps.yaml", "lights:\n  - {type: point, position: [1, 0, 0.2], intensity: 1}\n");
  RecordingContext context(inputs({{"lights", folder.path() / "lamps.yaml"}}));
  run_relight({.samples = 1}, context);
  const ImageF picture = read_exr_rgb(context.output() / "relit/lamps/view_0.exr");
  EXPECT_EQ(picture.at(1, 1, 0), 0);  // no environment behind
  EXPECT_GT(picture.at(32, 24, 0), 0.3);
}

// Black pictures are never written.
TEST_F(RelightStage, LightThatLightsNothingIsRefused) {
  const fs::path lamps = folder.path() / "lamps.yaml", map = folder.path() / "night.exr";
  const auto error_of_lamps = [&](const std::string& text) {
    write_file(lamps, "lights:" + text);
    return error_with({{"lights", lamps}});
  };
  EXPECT_NE(std::string(error_of_lamps(" []\n").what()).find("lamps.yaml:1:9: error: this list has no lamp"), std::string::npos);
  // The ball lies around the origin; its mesh has a radius of 0.4.
  const std::pair<std::string, std::string> idle[] = {
      {"\n  - {type: point, position: [1, 0, 0], intensity: 0}\n", "lamps.yaml:2:5: its intensity is 0"},
      {"\n  - {type: rectangle, center: [1, 0, 0], facing: [1, 0, 0], size: [1, 1], radiance: 5}\n", "faces away"},
      {"\n  - {type: point, position: [0, 0, 0], intensity: 5}\n", "every surface lies in shadow, or shows its back"}};
  for (const auto& [text, why] : idle) {
    const Error e = error_of_lamps(text);
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << text;
    EXPECT_EQ(e.detail().code, "LIGHT_NONE") << text;
    EXPECT_NE(e.detail().why.find(why), std::string::npos) << e.what();
  }
  for (const float radiance : {0.f, -1.f}) {
    write_exr_rgb(map, ImageF(16, 8, 3, radiance), ExrPrecision::Float);
    const Error e = error_with({{"env", map}});
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().code, "LIGHT_NONE");
    EXPECT_NE(e.detail().why.find("no texel of night.exr is brighter than 0"), std::string::npos) << e.what();
  }
}

TEST_F(RelightStage, LampsThatAddNothingAreNamed) {
  const fs::path lamps = folder.path() / "lamps.yaml", map = folder.path() / "night.exr";
  write_exr_rgb(map, ImageF(16, 8, 3), ExrPrecision::Float);
  write_file(lamps,
             "lights:\n  - {type: point, position: [1, 0, 0], intensity: 1}\n"
             "  - {type: disc, center: [1, 0, 0], facing: [1, 0, 0], radius: 1, radiance: 5}\n");
  RecordingContext context(inputs({{"lights", lamps}, {"env", map}}));
  run_relight({.width = 16, .height = 12, .samples = 1}, context);
  EXPECT_NE(context.warnings["LAMP_IDLE"].find("lamps.yaml:3:5: it faces away"), std::string::npos);
  EXPECT_TRUE(context.warnings.contains("ENV_BLACK"));
  EXPECT_FALSE(context.warnings.contains("ENV_LOW_RANGE"));
}

// As resampling leaves them around lamps, in maps that people share.
TEST_F(RelightStage, TexelsDarkerThanBlackAreToldAndTakenForBlack) {
  ImageF map(16, 8, 3, 2.f);
  std::vector<ImageF> pictures;
  for (const float level : {0.f, -3.f}) {
    map.at(4, 3, 1) = level;
    write_exr_rgb(folder.path() / "sky.exr", map, ExrPrecision::Float);
    RecordingContext context(inputs({{"env", folder.path() / "sky.exr"}}));
    run_relight({.width = 16, .height = 12, .samples = 1}, context);
    EXPECT_EQ(context.warnings.contains("ENV_NEGATIVE"), level < 0);
    if (level < 0) {
      EXPECT_EQ(context.warnings["ENV_NEGATIVE"], "1 of 128 texels of sky.exr are darker than black: taken for black there");
    }
    pictures.push_back(read_exr_rgb(context.output() / "relit/sky/view_0.exr"));
  }
  EXPECT_EQ(pictures[0], pictures[1]);
}

TEST_F(RelightStage, BadInputIsRefusedBeforeAnythingIsWritten) {
  const fs::path bad = folder.path() / "bad.exr";
  write_exr_rgb(bad, ImageF(8, 8, 3));
  EXPECT_EQ(error_with({{"env", bad}}).detail().code, "ENV_SHAPE");
  write_exr_rgb(bad, ImageF(8, 4, 3, std::numeric_limits<float>::infinity()), ExrPrecision::Float);
  EXPECT_EQ(error_with({{"env", bad}}).detail().code, "ENV_BAD_TEXELS");
  write_ldr(folder.path() / "sky.png", Image8(8, 4, 3));
  EXPECT_EQ(error_with({{"env", folder.path() / "sky.png"}}).detail().code, "ENV_LDR");
  write_file(folder.path() / "path.json",
             R"({"w": 32, "h": 24, "fl_x": 30, "frames": [{"file_path": "a.png", "transform_matrix":
                [[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]}]})");
  const Error singular = error_with({{"path", folder.path() / "path.json"}}, {.views = ViewChoice::Path});
  EXPECT_EQ(singular.kind(), ErrorKind::Input);
  EXPECT_NE(std::string(singular.what()).find("flattens space"), std::string::npos) << singular.what();
  write_file(folder.path() / "lamps.yaml", "lights:\n  - {type: candle}\n");
  EXPECT_EQ(error_with({{"lights", folder.path() / "lamps.yaml"}}).kind(), ErrorKind::Usage);
}

TEST_F(RelightStage, ScenesThatCannotBeRelitSaySo) {
  DecomposedMaterials few;
  few.resize(3);
  write_decomposed_materials(decompose(), few);
  EXPECT_EQ(error_with({}).detail().code, "BAD_MATERIALS");
  fs::remove(decomposed_materials_path(decompose()));
  EXPECT_EQ(error_with({}).kind(), ErrorKind::Input);
  write_decomposed_materials(decompose(), test::relit_ball({1, 1, 1}).materials);
  write_mesh_ply(capture.mesh() / "mesh/mesh.ply", TriMesh{});
  EXPECT_EQ(error_with({}).kind(), ErrorKind::Input);
}

}  // namespace
}  // namespace vitrine
