// The stage on folders: what it writes, reads back and refuses.
#include "stages/shapes/shapes.h"

#include <gtest/gtest.h>

#include "core/base/file.h"
#include "core/base/json.h"
#include "core/mesh/mesh_io.h"
#include "core/shape/shape_file.h"
#include "core/stereo/shapes_artifact.h"
#include "tests/core/stereo/silhouettes_of_rays.h"
#include "tests/stages/shapes/rod.h"
#include "tests/stages/shapes/written_capture.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using test::RecordingContext;

const Box kCase{Mat3d::identity(), {-0.45, -0.15, -0.2}, {-0.1, 0.15, 0.2}};

// Photos of things of glass and of metal, as the stages before leave them.
struct Scene {
  TemporaryFolder folder;
  fs::path sfm() const { return folder.path() / "sfm"; }
  fs::path masks() const { return folder.path() / "masks"; }

  Scene(const std::vector<Silhouette>& glass, const std::vector<Silhouette>& metal) {
    const auto views = test::write_sfm(
        sfm(), glass, [](const View& view) { return ImageF(view.intrinsics.width, view.intrinsics.height, 3, 0.3f); });
    test::write_masks(masks(), MaskClass::Transparent, views, glass);
    test::write_masks(masks(), MaskClass::Specular, views, metal);
  }
};

template <class Meets>
std::vector<Silhouette> around(const Meets& meets) {
  return silhouettes_of_rays(24, 2 * std::numbers::pi, meets);
}

// A case of glass, and a ball of metal with a handle.
const Scene& scene() {
  static const Vec3d ball{0.25, 0, 0};
  static const test::Rod handle{{0.42, 0, 0.03}, {0.6, 0, 0.1}};
  static const Scene scene(
      around([](const Vec3d& eye, const Vec3d& d) { return kCase.crossing(eye, d).has_value(); }),
      around([](const Vec3d& eye, const Vec3d& d) { return meets_ball(ball, 0.2, eye, d) || handle.distance(eye, d) < 0.035; }));
  return scene;
}

std::unique_ptr<RecordingContext> run(std::map<std::string, fs::path> more = {},
                                      const std::vector<std::pair<std::string, std::string>>& options = {}) {
  more.try_emplace("sfm", scene().sfm());
  auto context = std::make_unique<RecordingContext>(more);
  Stage stage = shapes_stage();
  stage.options.find("resolution")->assign("64", "test");
  for (const auto& [path, text] : options) stage.options.find(path)->assign(text, "test");
  stage.run(*context);
  return context;
}
std::unique_ptr<RecordingContext> fitted() { return run({{"masks", scene().masks()}}); }

TEST(ShapesStage, FindsACaseAndABallWithItsHandle) {
  const auto context = fitted();
  const ShapeSet set = read_shapes_artifact(context->output());
  ASSERT_EQ(set.entries.size(), 3u);
  EXPECT_TRUE(std::holds_alternative<Box>(set.entries[0].shape));
  EXPECT_TRUE(std::holds_alternative<SurfaceOfRevolution>(set.entries[1].shape));
  EXPECT_EQ(set.entries[2].parent, 1);
  for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(kCase.distance(std::get<Box>(set.entries[0].shape).corner(i)), 0, 0.01);
  const auto j = nlohmann::json::parse(read_file(context->output() / "shapes/shapes.json"));
  for (size_t i : {0, 1}) {
    EXPECT_GT(j["shapes"][i]["inside_masks"], 0.93);
    EXPECT_GT(j["shapes"][i]["masks_covered"], 0.93);
    EXPECT_EQ(j["shapes"][i]["source"], "fitted");
  }
  EXPECT_GT(read_mesh_ply(context->output() / "shapes/shapes.ply").faces.size(), 500u);
  EXPECT_TRUE(fs::exists(context->output() / "shapes/contact_sheet.png"));
}

TEST(ShapesStage, FindsAWindowInAWallAndABallInFrontOfIt) {
  const Plane window{{-0.8, 0, 0.1}, Mat3d{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {0.3, 0.2}};
  const auto glass = around([&](const Vec3d& eye, const Vec3d& d) {
    const auto hit = window.intersect({eye, d});
    return (hit && hit->element == 0) || meets_ball({0.3, 0.2, -0.25}, 0.12, eye, d);
  });
  auto metal = glass;
  for (Silhouette& s : metal) std::ranges::fill(s.value.data(), 0.f);
  const Scene room(glass, metal);
  const auto context = run({{"sfm", room.sfm()}, {"masks", room.masks()}});
  const ShapeSet set = read_shapes_artifact(context->output());
  ASSERT_EQ(set.entries.size(), 2u);
  const auto* plane = std::get_if<Plane>(&set.entries[0].shape);
  ASSERT_NE(plane, nullptr);
  EXPECT_EQ(set.entries[0].role, ShapeRole::Sheet);
  EXPECT_DOUBLE_EQ(set.entries[0].tolerance, 0.02 * plane->size());
  EXPECT_GT(dot(plane->axes.c2, window.axes.c2), 0.999) << "2.5 degrees; its front faces the cameras";
  for (const Vec3d& p : window.outer_points()) EXPECT_LT(length(plane->nearest(p).position - p), 0.05) << "two pixels";
  EXPECT_TRUE(std::holds_alternative<SurfaceOfRevolution>(set.entries[1].shape));
}

TEST(ShapesStage, GivesTheSameBytesForAnyNumberOfThreads) {
  const auto bytes = [](int threads) {
    set_thread_limit(threads);
    const auto context = fitted();
    set_thread_limit(0);
    return read_file(context->output() / "shapes/shapes.json") + read_file(context->output() / "shapes/shapes.ply");
  };
  EXPECT_EQ(bytes(1), bytes(4));
}

// A person turns the case's floor into no pane and raises its roof; all else stays as it was found.
TEST(ShapesStage, TakesWhatAPersonCorrected) {
  const auto found = fitted();
  TemporaryFolder mine;
  fs::copy(found->output() / "shapes", mine.path(), fs::copy_options::recursive);
  auto j = nlohmann::ordered_json::parse(read_file(mine.path() / "shapes.json"));
  j["shapes"][0]["high"][2] = 0.25;
  j["shapes"][0]["clear"] = {1, 1, 1, 1, 0, 1};
  write_file(mine.path() / "shapes.json", readable(j));
  for (const fs::path& given : {mine.path() / "shapes.json", mine.path()}) {
    const auto context = run({{"masks", scene().masks()}, {"shapes", given}});
    const ShapeSet set = read_shapes_artifact(context->output());
    ASSERT_EQ(set.entries.size(), 3u);
    EXPECT_EQ(std::get<Box>(set.entries[0].shape).high.z, 0.25);
    EXPECT_FALSE(set.entries[0].is_clear(4));
    EXPECT_EQ(nlohmann::json::parse(read_file(context->output() / "shapes/shapes.json"))["shapes"][1]["source"], "given");
    EXPECT_TRUE(context->warnings.empty());
  }
  EXPECT_EQ(meant_shapes(mine.path() / "shapes.json"), mine.path()) << "its meshes are part of it";
  const auto again = run({{"masks", scene().masks()}, {"shapes", mine.path()}}, {{"source", "fitted"}});
  EXPECT_LT(std::get<Box>(read_shapes_artifact(again->output()).entries[0].shape).high.z, 0.22);
  const auto none = run({{"masks", scene().masks()}, {"shapes", mine.path()}}, {{"source", "none"}});
  EXPECT_TRUE(read_shapes_artifact(none->output()).entries.empty());
}

TEST(ShapesStage, SaysWhenPhotosDoubtAGivenShape) {
  TemporaryFolder mine;
  const ShapeSet wrong{.entries = {{Box{Mat3d::identity(), {0.1, 0.2, 0.2}, {0.4, 0.5, 0.5}}, ShapeRole::Sheet, 0.01, -1, {}}}};
  write_file(mine.path() / "shapes.json", nlohmann::ordered_json{{"shapes", write_shapes(wrong, mine.path())}}.dump());
  const auto doubted = run({{"masks", scene().masks()}, {"shapes", mine.path() / "shapes.json"}});
  EXPECT_TRUE(doubted->warnings.contains("SHAPE_OUTSIDE_MASKS"));
  const auto unmarked = run({{"shapes", mine.path() / "shapes.json"}});
  EXPECT_TRUE(unmarked->warnings.contains("SHAPES_WITHOUT_MASKS"));
  EXPECT_EQ(read_shapes_artifact(unmarked->output()).entries.size(), 1u);
}

// Sheets were used without a word where only metal is marked.
TEST(ShapesStage, SaysWhichClassOfGivenShapesHasNoMasks) {
  TemporaryFolder mine, metal_alone;
  fs::create_directories(metal_alone.path() / "masks");
  fs::copy(scene().masks() / "masks" / "specular", metal_alone.path() / "masks" / "specular", fs::copy_options::recursive);
  const auto warned = [&](ShapeRole role) {
    const ShapeSet given{.entries = {{kCase, role, 0.01, -1, {}}}};
    write_file(mine.path() / "shapes.json", nlohmann::ordered_json{{"shapes", write_shapes(given, mine.path())}}.dump());
    const auto context = run({{"masks", metal_alone.path()}, {"shapes", mine.path() / "shapes.json"}});
    const auto found = context->warnings.find("SHAPES_WITHOUT_MASKS");
    return found == context->warnings.end() ? std::string() : found->second;
  };
  EXPECT_NE(warned(ShapeRole::Sheet).find("shapes of glass are given, but no transparent mask"), std::string::npos);
  EXPECT_EQ(warned(ShapeRole::Mirror), "");
  EXPECT_EQ(warned(ShapeRole::Coat), "");
}

TEST(ShapesStage, NamesThePlaceOfAMistake) {
  TemporaryFolder mine;
  const fs::path file = mine.path() / "shapes.json";
  const auto error_in = [&](const std::string& text) {
    write_file(file, text);
    return error_of([&] { run({{"shapes", file}}); });
  };
  const std::string box = R"({"kind": "box", "role": "sheet", "tolerance": 0.02,
    "axes": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "low": [0, 0, 0], "high": [1, 1, 1]})";
  EXPECT_EQ(error_in("{\"shapes\": [\n" + box + ",\n{\"kind\": \"cube\"}]}").detail().where, file.string() + ":4:1");
  EXPECT_EQ(error_in(R"({"shapes": 3})").kind(), ErrorKind::Input);
  EXPECT_EQ(error_in("{}").kind(), ErrorKind::Input);
  EXPECT_EQ(error_in("not JSON").kind(), ErrorKind::Input);
  EXPECT_EQ(error_in(R"({"shapes": [{"kind": "triangles", "role": "mirror", "tolerance": 1, "mesh": "shape_0.ply"}]})").kind(),
            ErrorKind::Input)
      << "its mesh is missing";
}

TEST(ShapesStage, WithoutMasksNothingIsFound) {
  const auto context = run();
  EXPECT_TRUE(read_shapes_artifact(context->output()).entries.empty());
  EXPECT_FALSE(fs::exists(context->output() / "shapes/shapes.ply"));
}

TEST(ReadableJson, PutsPlainArraysOnALine) {
  const auto text = R"({"a [b": [1, 2.5, "x\" ] y"], "c": [[1, 2], [3, 4]], "d": [], "e": {"f": [true, null]}})";
  const auto j = nlohmann::ordered_json::parse(text);
  const std::string out = readable(j);
  EXPECT_EQ(nlohmann::ordered_json::parse(out), j);
  EXPECT_NE(out.find("\n    [1, 2],\n"), std::string::npos) << out;
  EXPECT_NE(out.find("\"f\": [true, null]"), std::string::npos) << out;
}

}  // namespace
}  // namespace vitrine
