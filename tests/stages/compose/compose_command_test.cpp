// `vitrine compose`: the folder that it makes, the commands that take it, and what it refuses.
#include <cstdlib>

#include <gtest/gtest.h>

#include "core/render/relight/relit_scene.h"
#include "core/scene/image/exr.h"
#include "core/scene/objects/object_set.h"
#include "pipeline/commands.h"
#include "pipeline/project.h"
#include "tests/stages/compose/projects.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

constexpr const char* kRoom = "  - project: room\n";
constexpr const char* kBall =
    "  - {project: shelf, select: {object: reflecting}, place: {translate: [0, 0, 0.25], scale: 0.5}}\n";

class ComposeCommand : public testing::Test {
 protected:
  const fs::path out() const { return projects_.at("out"); }
  int compose(const std::string& parts) const {
    return compose_command({projects_.list(parts).string(), "-o", out().string(), "--quiet", "--no-progress"});
  }
  Words on_composition(const Words& more) const {
    Words words{out().string(), "--quiet", "--no-progress"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  static size_t ball_a() { return test::TwoBalls::kSurfelsA + test::TwoBalls::kHidden; }
  static size_t all() { return test::Projects::balls().layer.size(); }
  void expect_refused(const std::string& parts, ErrorKind kind) const {
    EXPECT_EQ(compose(parts), exit_code(kind)) << parts;
    EXPECT_FALSE(fs::exists(out())) << "nothing is written";
  }

  test::Projects projects_;
};

TEST_F(ComposeCommand, OneSceneAtItsPlaceKeepsItsBytes) {
  ASSERT_EQ(compose(kRoom), 0);
  for (const char* file : {"gaussians/diffuse.ply", "gaussians/transmittance.ply", "decompose/materials.ply"}) {
    const fs::path original = store_of(projects_.at("room")) / (file[0] == 'g' ? "optimize" : "decompose") / std::string(32, 'r');
    EXPECT_EQ(read_file(out() / file), read_file(original / file)) << file;
  }
  EXPECT_EQ(read_objects(store_of(out()) / "objects" / *current_key(out(), "objects")).objects.size(), 1u);
}

TEST_F(ComposeCommand, AnObjectOfAnotherSceneStandsAtItsPlace) {
  ASSERT_EQ(compose(std::string(kRoom) + kBall), 0);
  const RelitScene scene = read_relit_scene({.optimize = out(), .mesh = out(), .decompose = out()});
  const SplatLayer& surfels = scene.trained.surfels.diffuse;
  ASSERT_EQ(surfels.size(), all() + ball_a());
  ASSERT_EQ(scene.materials.size(), surfels.size());
  const float *was = test::Projects::balls().layer.at(Attribute::Mean, 3), *is = surfels.at(Attribute::Mean, all() + 3);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(is[c], 0.5f * was[c] + (c == 2 ? 0.25f : 0.f), 1e-5f);
  EXPECT_EQ(scene.materials.albedo[all() + 3], test::Projects::balls().materials.albedo[3]);
  const ObjectSet objects = read_objects(store_of(out()) / "objects" / *current_key(out(), "objects")).known();
  ASSERT_EQ(objects.objects.size(), 2u);
  EXPECT_EQ(objects.objects[1].name, "reflecting_2");
  EXPECT_EQ(surfels.object_ids().back(), objects.objects[1].id);
  EXPECT_TRUE(fs::exists(out() / "objects/labels/view_0.png")) << "of the photos of the first part";
}

TEST_F(ComposeCommand, EveryCommandTakesTheComposition) {
  ASSERT_EQ(compose(std::string(kRoom) + kBall), 0);
  const Words picture{"--views", "heldout", "--size", "32x24"};
  EXPECT_EQ(render_command(on_composition(picture)), 0);
  Words relit = picture;
  relit.insert(relit.end(), {"--spp", "2"});
  EXPECT_EQ(relight_command(on_composition(relit)), 0);
  const bool page = view_command(on_composition({})) != exit_code(ErrorKind::Dependency);  // a build without npm has none
  EXPECT_EQ(export_command(on_composition({"--set", "formats=[mesh-glb,ply-3dgs]"})), 0);
  for (const char* made : {"render/view_0.png", "relit/captured/view_0.png", "export/mesh.glb"})
    EXPECT_TRUE(fs::exists(out() / made)) << made;
  EXPECT_EQ(fs::exists(out() / "view.html"), page);
  write_file(projects_.at("edits.yaml"), "edits:\n  - select: {object: reflecting_2}\n    delete: true\n");
  EXPECT_EQ(edit_command({out().string(), projects_.at("edits.yaml").string(), "--quiet", "--no-progress"}), 0);
  EXPECT_EQ(read_layer(out() / "edited/gaussians/diffuse.ply").size(), all());
  EXPECT_EQ(error_of([&] { run_command({out().string()}); }).detail().code, "COMPOSITION");
}

TEST_F(ComposeCommand, AGuestStandsInAPhotoOfItsHost) {
  ASSERT_EQ(compose(std::string(kRoom) + kBall), 0);
  const auto over = [&](const fs::path& project, const std::string& photo, const Words& more = {}) {
    Words words{project.string(), "--over", photo, "--spp", "2", "--quiet", "--no-progress"};
    words.insert(words.end(), more.begin(), more.end());
    return relight_command(words);
  };
  EXPECT_EQ(over(out(), "somewhere/view_3.png"), 0);
  const ExrImage guest = read_exr(out() / "relit/captured_over/view_3.exr");
  EXPECT_EQ(guest.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
  EXPECT_GT(std::ranges::count_if(guest.pixels.data(), [](float v) { return v > 0.9f; }), 10);
  for (const char* file : {"view_3_shadow.exr", "view_3.png", "settings.json"})
    EXPECT_TRUE(fs::exists(out() / "relit/captured_over" / file)) << file;
  EXPECT_EQ(over(out(), "holiday.jpg"), exit_code(ErrorKind::Input)) << "no camera";
  EXPECT_EQ(over(out(), "view_3.png", {"--turntable", "4"}), exit_code(ErrorKind::Usage));
  EXPECT_EQ(over(projects_.at("room"), "view_3.png"), exit_code(ErrorKind::Input)) << "no guest";
}

TEST_F(ComposeCommand, AnEarlierCompositionIsReplaced) {
  ASSERT_EQ(compose(std::string(kRoom) + kBall), 0);
  projects_.forget("shelf", "decompose");
  ASSERT_EQ(compose(std::string(kRoom) + kBall), 0);  // with the warning that it cannot be relit
  EXPECT_FALSE(fs::exists(out() / "decompose/materials.ply"));
  EXPECT_EQ(error_of([&] { relight_command(on_composition({})); }).detail().code, "PART_INCOMPLETE");
  EXPECT_EQ(compose("  - project: room\n    place: {scale: 2}\n"), exit_code(ErrorKind::Usage));
  EXPECT_EQ(read_layer(out() / "gaussians/diffuse.ply").size(), all() + ball_a()) << "a list that fails leaves what is there";
  ASSERT_EQ(compose(std::string(kRoom) + "  - {project: room, place: {translate: [2, 0, 0]}}\n"), 0);  // twice the same scene
  EXPECT_EQ(read_layer(out() / "gaussians/diffuse.ply").size(), 2 * all() - test::TwoBalls::kSky) << "one sky";
}

TEST_F(ComposeCommand, BadListsAreRefusedWithTheirReason) {
  expect_refused("  - {project: room, colour: red}\n", ErrorKind::Usage);
  expect_refused(std::string(kRoom) + kRoom, ErrorKind::Usage);
  expect_refused(std::string(kRoom) + "  - {project: shelf, place: {scale: 0}}\n", ErrorKind::Usage);
  expect_refused(std::string(kRoom) + "  - {project: shelf, place: {scale: 1, rotate: {axis: [0, 0, 0], angle: 3}}}\n",
                 ErrorKind::Usage);
  expect_refused(std::string(kRoom) + "  - project: shelf\n", ErrorKind::Input);  // no common unit
  expect_refused(std::string(kRoom) + "  - {project: shelf, select: {object: door}, place: {scale: 1}}\n", ErrorKind::Input);
  expect_refused(std::string(kRoom) + "  - {project: shelf, select: {box: [8, 8, 8, 9, 9, 9]}, place: {scale: 1}}\n",
                 ErrorKind::Input);
  expect_refused(std::string(kRoom) + "  - {project: shelf, edited: true, place: {scale: 1}}\n", ErrorKind::Input);
  expect_refused("  - project: nowhere\n", ErrorKind::Input);
  projects_.forget("shelf", "mesh");
  expect_refused(std::string(kRoom) + "  - {project: shelf, place: {scale: 1}}\n", ErrorKind::Input);
}

TEST_F(ComposeCommand, TheOutputFolderIsFreeOrAComposition) {
  const std::string list = projects_.list(kRoom).string();
  const auto refused = [&](const fs::path& folder) {
    const Error e = error_of([&] { compose_command({list, "-o", folder.string()}); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage);
    return e.message();
  };
  EXPECT_EQ(refused(projects_.at("room")), "the output folder is one of the parts");
  EXPECT_EQ(refused(projects_.at("shelf")), "the output folder contains other files");
  EXPECT_EQ(error_of([&] { compose_command({list}); }).kind(), ErrorKind::Usage);
  EXPECT_EQ(error_of([&] { compose_command({projects_.at("none.yaml").string(), "-o", "x"}); }).detail().code, "MISSING_INPUT");
  make_folders(out());
  EXPECT_EQ(compose("  - project: nowhere\n"), exit_code(ErrorKind::Input));
  EXPECT_TRUE(fs::is_empty(out())) << "a folder that was there stays as it was";
}

}  // namespace
}  // namespace vitrine
