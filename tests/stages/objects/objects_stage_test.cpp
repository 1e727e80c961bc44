// The stage on folders: what it writes, reads back and refuses.
#include "stages/objects/objects.h"

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/objects/object_labels.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"
#include "tests/stages/objects/rod.h"
#include "tests/stages/objects/written_capture.h"
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
  ObjectsConfig config{.hull_voxels = 64};
  OptionTable table = options_of(config);
  for (const auto& [path, text] : options) table.find(path)->assign(text, "test");
  run_objects(config, *context);
  return context;
}
std::unique_ptr<RecordingContext> fitted() { return run({{"masks", scene().masks()}}); }

TEST(ObjectsStage, FindsACaseAndABallWithItsHandle) {
  const auto context = fitted();
  const ObjectSet set = read_objects(context->output());
  ASSERT_EQ(set.shapes.entries.size(), 3u);
  EXPECT_TRUE(std::holds_alternative<Box>(set.shapes.entries[0].shape));
  EXPECT_TRUE(std::holds_alternative<SurfaceOfRevolution>(set.shapes.entries[1].shape));
  EXPECT_EQ(set.shapes.entries[2].parent, 1);
  for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(kCase.distance(std::get<Box>(set.shapes.entries[0].shape).corner(i)), 0, 0.01);
  ASSERT_EQ(set.objects.size(), 2u);
  EXPECT_EQ(set.objects[0].role, ObjectRole::ThinGlass);
  EXPECT_EQ(set.objects[0].name, "glass-1");
  EXPECT_NE(set.objects[1].role, ObjectRole::ThinGlass) << "all photos are grey: which of mirror and coat is open";
  for (const Object& object : set.objects) {
    EXPECT_EQ(object.trust, ObjectTrust::Given) << "masks of the user's own";
    EXPECT_GT(object.evidence.inside.value(), 0.93);
    EXPECT_GT(object.evidence.covered.value(), 0.93);
    EXPECT_EQ(object.evidence.views, 21u) << "of the 24 photos three are held out";
  }
  EXPECT_EQ(set.shapes.entries[1].object, set.shapes.entries[2].object) << "a handle has the identity of what it stands out of";
  EXPECT_GT(read_mesh_ply(context->output() / "objects/shapes.ply").faces.size(), 500u);
  EXPECT_TRUE(fs::exists(context->output() / "objects/contact_sheet.png"));
}

// Every marked pixel has a label, that of the object that stands there.
TEST(ObjectsStage, LabelsEveryMarkedPixel) {
  const auto context = fitted();
  const LabelledObjects objects = LabelledObjects::all(context->output());
  const auto views = load_view_set(scene().sfm()).views;
  for (uint32_t v = 1; v < 8; ++v) {
    const Image16 labels = objects.labels(views[v], views[v].intrinsics);
    const ImageF glass = *read_view_mask(scene().masks(), MaskClass::Transparent, views[v]);
    const ImageF metal = *read_view_mask(scene().masks(), MaskClass::Specular, views[v]);
    ASSERT_EQ(labels.width(), glass.width());
    for (size_t i = 0; i < labels.data().size(); ++i)
      ASSERT_EQ(labels.data()[i], glass.data()[i] >= 0.5f ? 1 : metal.data()[i] >= 0.5f ? 2 : 0) << v << " " << i;
  }
}

TEST(ObjectsStage, FindsAWindowInAWallAndABallInFrontOfIt) {
  const Plane window{{-0.8, 0, 0.1}, Mat3d{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {0.3, 0.2}};
  const auto glass = around([&](const Vec3d& eye, const Vec3d& d) {
    const auto hit = window.intersect({eye, d});
    return (hit && hit->element == 0) || meets_ball({0.3, 0.2, -0.25}, 0.12, eye, d);
  });
  auto metal = glass;
  for (Silhouette& s : metal) std::ranges::fill(s.value.data(), 0.f);
  const Scene room(glass, metal);
  const auto context = run({{"sfm", room.sfm()}, {"masks", room.masks()}});
  const ShapeSet set = read_objects(context->output()).shapes;
  ASSERT_EQ(set.entries.size(), 2u);
  const auto* plane = std::get_if<Plane>(&set.entries[0].shape);
  ASSERT_NE(plane, nullptr);
  EXPECT_EQ(set.entries[0].role, ShapeRole::Sheet);
  EXPECT_DOUBLE_EQ(set.entries[0].tolerance, 0.02 * plane->size());
  EXPECT_GT(dot(plane->axes.c2, window.axes.c2), 0.999) << "2.5 degrees; its front faces the cameras";
  for (const Vec3d& p : window.outer_points()) EXPECT_LT(length(plane->nearest(p).position - p), 0.05) << "two pixels";
  EXPECT_TRUE(std::holds_alternative<SurfaceOfRevolution>(set.entries[1].shape));
}

TEST(ObjectsStage, GivesTheSameBytesForAnyNumberOfThreads) {
  const auto bytes = [](int threads) {
    set_thread_limit(threads);
    const auto context = fitted();
    set_thread_limit(0);
    return read_file(context->output() / "objects/objects.json") + read_file(context->output() / "objects/shapes.ply") +
           read_file(context->output() / "objects/labels/v05.png");
  };
  EXPECT_EQ(bytes(1), bytes(4));
}

// A person turns the case's floor into no pane, raises its roof, names it and says that the ball is a mirror.
TEST(ObjectsStage, TakesWhatAPersonCorrected) {
  const auto found = fitted();
  TemporaryFolder mine;
  fs::copy(found->output() / "objects", mine.path(), fs::copy_options::recursive);
  auto j = nlohmann::ordered_json::parse(read_file(mine.path() / "objects.json"));
  j["objects"][0]["shapes"][0]["high"][2] = 0.25;
  j["objects"][0]["shapes"][0]["clear"] = {1, 1, 1, 1, 0, 1};
  j["objects"][0]["name"] = "case";
  j["objects"][1]["role"] = "mirror";
  j["objects"][1]["id"] = 7;
  write_file(mine.path() / "objects.json", readable(j));
  for (const fs::path& given : {mine.path() / "objects.json", mine.path()}) {
    const auto context = run({{"masks", scene().masks()}, {"objects", given}});
    const ObjectSet set = read_objects(context->output());
    ASSERT_EQ(set.shapes.entries.size(), 3u);
    EXPECT_EQ(std::get<Box>(set.shapes.entries[0].shape).high.z, 0.25);
    EXPECT_FALSE(set.shapes.entries[0].is_clear(4));
    EXPECT_EQ(set.objects[0].name, "case");
    EXPECT_EQ(set.find(7)->role, ObjectRole::Mirror);
    EXPECT_EQ(set.shapes.entries[2].role, ShapeRole::Mirror);
    const auto views = load_view_set(scene().sfm()).views;
    const Image16 labels = LabelledObjects::all(context->output()).labels(views[1], views[1].intrinsics);
    EXPECT_EQ(std::ranges::count(labels.data(), 2), 0) << "ids are the person's";
    EXPECT_GT(std::ranges::count(labels.data(), 7), 100);
    EXPECT_TRUE(context->warnings.empty());
  }
  EXPECT_EQ(meant_objects(mine.path() / "objects.json"), mine.path()) << "its meshes are part of it";
  const auto again = run({{"masks", scene().masks()}, {"objects", mine.path()}}, {{"source", "fitted"}});
  EXPECT_LT(std::get<Box>(read_objects(again->output()).shapes.entries[0].shape).high.z, 0.22);
}

// Without shapes the masks count all the same: one object a class, at no known place.
TEST(ObjectsStage, WithoutShapesEachClassIsOneObject) {
  const auto context = run({{"masks", scene().masks()}}, {{"source", "none"}});
  const ObjectSet set = read_objects(context->output());
  EXPECT_TRUE(set.shapes.entries.empty());
  ASSERT_EQ(set.objects.size(), 2u);
  EXPECT_TRUE(context->warnings.contains("OBJECT_WITHOUT_SHAPE"));
  EXPECT_EQ(set.objects[0].role, ObjectRole::ThinGlass);
  EXPECT_EQ(set.objects[1].role, ObjectRole::Coat) << "its surfels show what it reflects";
  EXPECT_EQ(set.trusted().objects.size(), 2u);
}

TEST(ObjectsStage, SaysWhenPhotosDoubtAGivenObject) {
  TemporaryFolder mine;
  const ObjectSet wrong{.objects = {{.id = 1, .name = "vase", .role = ObjectRole::ThinGlass}},
                        .shapes = {.entries = {{.shape = Box{Mat3d::identity(), {0.1, 0.2, 0.2}, {0.4, 0.5, 0.5}},
                                                .role = ShapeRole::Sheet,
                                                .tolerance = 0.01,
                                                .clear = {},
                                                .object = 1}}}};
  write_objects(mine.path(), wrong);
  const auto doubted = run({{"masks", scene().masks()}, {"objects", mine.path() / "objects.json"}});
  EXPECT_TRUE(doubted->warnings.contains("OBJECT_OUTSIDE_MASKS"));
  const auto unmarked = run({{"objects", mine.path() / "objects.json"}});
  EXPECT_TRUE(unmarked->warnings.contains("OBJECTS_WITHOUT_MASKS"));
  EXPECT_EQ(read_objects(unmarked->output()).shapes.entries.size(), 1u);
}

// Sheets were used without a word where only metal is marked.
TEST(ObjectsStage, SaysWhichClassOfGivenObjectsHasNoMasks) {
  TemporaryFolder mine, metal_alone;
  fs::create_directories(metal_alone.path() / "masks");
  fs::copy(scene().masks() / "masks" / "specular", metal_alone.path() / "masks" / "specular", fs::copy_options::recursive);
  const auto warned = [&](ObjectRole role) {
    const ObjectSet given{
        .objects = {{.id = 1, .name = "case", .role = role}},
        .shapes = {.entries = {{.shape = kCase, .role = shape_role(role), .tolerance = 0.01, .clear = {}, .object = 1}}}};
    write_objects(mine.path(), given);
    const auto context = run({{"masks", metal_alone.path()}, {"objects", mine.path() / "objects.json"}});
    const auto found = context->warnings.find("OBJECTS_WITHOUT_MASKS");
    return found == context->warnings.end() ? std::string() : found->second;
  };
  EXPECT_NE(warned(ObjectRole::ThinGlass).find("objects of glass are given, but no transparent mask"), std::string::npos);
  EXPECT_EQ(warned(ObjectRole::Mirror), "");
  EXPECT_EQ(warned(ObjectRole::Coat), "");
}

TEST(ObjectsStage, WithoutMasksNothingIsFound) {
  const auto context = run();
  EXPECT_TRUE(read_objects(context->output()).empty());
  EXPECT_FALSE(fs::exists(context->output() / "objects/shapes.ply"));
}

// What a person called the things that they marked, whatever the class has more.
TEST(ObjectsStage, TakesTheNamesOfMarks) {
  TemporaryFolder marked;
  fs::copy(scene().masks(), marked.path(), fs::copy_options::recursive);
  write_mask_origins(marked.path(),
                     {{MaskClass::Transparent, {"boxes", "marked", true}}, {MaskClass::Specular, {"boxes", "marked", true}}},
                     {"", "kettle", "showcase"});
  const auto views = load_view_set(scene().sfm()).views;
  for (const View& view : views) {
    const ImageF glass = *read_view_mask(scene().masks(), MaskClass::Transparent, view);
    const ImageF metal = *read_view_mask(scene().masks(), MaskClass::Specular, view);
    Image16 things(glass.width(), glass.height(), 1);
    for (size_t i = 0; i < things.data().size(); ++i) things.data()[i] = glass.data()[i] > 0 ? 3 : metal.data()[i] > 0 ? 2 : 0;
    make_folders(marked_objects_path(marked.path(), view).parent_path());
    write_png16(marked_objects_path(marked.path(), view), things);
  }
  const ObjectSet set = read_objects(run({{"masks", marked.path()}})->output());
  ASSERT_EQ(set.objects.size(), 2u);
  EXPECT_EQ(set.objects[0].name, "showcase");
  EXPECT_EQ(set.objects[1].name, "kettle");
  EXPECT_EQ(set.objects[1].trust, ObjectTrust::Marked);
}

// Masks that the masks stage only guessed become objects that later stages leave alone.
TEST(ObjectsStage, GuessedMasksMakeGuessedObjects) {
  TemporaryFolder guessed;
  fs::copy(scene().masks(), guessed.path(), fs::copy_options::recursive);
  write_mask_origins(guessed.path(),
                     {{MaskClass::Transparent, {"proposed", "guessed", true}}, {MaskClass::Specular, {"boxes", "marked", true}}});
  const ObjectSet set = read_objects(run({{"masks", guessed.path()}})->output());
  ASSERT_EQ(set.objects.size(), 2u);
  EXPECT_EQ(set.objects[0].trust, ObjectTrust::Guessed);
  EXPECT_EQ(set.objects[1].trust, ObjectTrust::Marked);
  const ObjectSet trusted = set.trusted();
  ASSERT_EQ(trusted.objects.size(), 1u);
  EXPECT_EQ(trusted.objects[0].id, 2);
  EXPECT_FALSE(trusted.shapes.has(ShapeRole::Sheet));
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
