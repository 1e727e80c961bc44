// Lists of parts: places, units, names; what enters the key.
#include <cmath>

#include <gtest/gtest.h>

#include "core/scene/camera/scene_info.h"
#include "stages/compose/compose.h"
#include "tests/stages/compose/projects.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

class CompositionFile : public testing::Test {
 protected:
  std::vector<CompositionPart> read(const std::string& parts) const { return read_composition(projects_.list(parts)); }
  void measure(const std::string& project, char salt, double metres) const {
    SceneInfo info;
    info.scale_known = true, info.scene_from_colmap.scale = 1 / metres;
    write_scene_info(store_of(projects_.at(project)) / "sfm" / std::string(32, salt) / "scene.json", info);
  }
  // The options of the artifact of the stage export, which `vitrine run --scale-bar` sets.
  void export_with(const std::string& project, const char* option, const std::string& value) const {
    ArtifactStore store(store_of(projects_.at(project)));
    PendingArtifact pending(store, "export", "e");
    Manifest manifest;
    manifest.stage = "export", manifest.key = "e", manifest.options = {{option, value, "--set"}};
    pending.commit(manifest, "{}");
    set_current_key(projects_.at(project), "export", "e");
  }
  // Another run of sfm, with this frame and given poses.
  void pose(const std::string& project, const std::string& poses, const Similarity& scene_from_colmap) const {
    ArtifactStore store(store_of(projects_.at(project)));
    const std::string key = "p" + poses + project;
    PendingArtifact pending(store, "sfm", key);
    fs::copy(store_of(projects_.at(project)) / "sfm" / *current_key(projects_.at(project), "sfm"), pending.path(),
             fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    SceneInfo info;
    info.scene_from_colmap = scene_from_colmap;
    write_scene_info(pending.path() / "scene.json", info);
    Manifest manifest;
    manifest.stage = "sfm", manifest.key = key, manifest.terms = {{"input.poses", poses}};
    pending.commit(manifest, "{}");
    set_current_key(projects_.at(project), "sfm", key);
  }
  test::Projects projects_;
};

TEST_F(CompositionFile, APlaceIsASimilarity) {
  const auto parts = read(
      "  - project: room\n  - project: shelf\n    name: second shelf\n"
      "    place: {translate: [1, 2, 3], rotate: {angle: 90}, scale: 2}\n");
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].name, "room");
  EXPECT_EQ(parts[1].name, "second shelf");
  EXPECT_EQ(parts[0].place * (Vec3d{1, 2, 3}), (Vec3d{1, 2, 3}));
  EXPECT_LT(length(parts[1].place * Vec3d{1, 0, 0} - Vec3d{1, 4, 3}), 1e-12) << "counter-clockwise about +z, then moved";
}

TEST_F(CompositionFile, TheScaleFollowsFromMeasuredUnits) {
  const std::string two = "  - project: room\n  - project: shelf\n";
  const Error unknown = error_of([&] { read(two); });
  EXPECT_EQ(unknown.detail().code, "NO_COMMON_UNIT");
  EXPECT_NE(unknown.detail().where.find("scene.yaml:3:"), std::string::npos) << unknown.what();
  measure("room", 'r', 2);
  EXPECT_NE(error_of([&] { read(two); }).detail().why.find("'shelf'"), std::string::npos);
  measure("shelf", 's', 0.5);
  EXPECT_NEAR(read(two)[1].place.scale, 0.25, 1e-12);
  EXPECT_EQ(read("  - project: room\n  - {project: shelf, place: {scale: 3}}\n")[1].place.scale, 3) << "what is given wins";
}

TEST_F(CompositionFile, TheOptionsOfExportAreAMeasureToo) {
  measure("room", 'r', 2);
  const std::string two = "  - project: room\n  - project: shelf\n";
  export_with("shelf", "scale", "0.5");
  EXPECT_NEAR(read(two)[1].place.scale, 0.25, 1e-12);
  export_with("shelf", "scale_points", "0,0,0 0,0,2 2m");
  EXPECT_NEAR(read(two)[1].place.scale, 0.5, 1e-12);
}

TEST_F(CompositionFile, AScenesCopyNeedsNoUnitButAnotherPlace) {
  EXPECT_EQ(read("  - project: room\n  - {project: room, place: {translate: [1, 0, 0]}}\n")[1].place.scale, 1);
  EXPECT_EQ(error_of([&] { read("  - project: room\n  - project: room\n"); }).kind(), ErrorKind::Usage);
}

TEST_F(CompositionFile, PartsWithTheSamePosesKeepTheirFrame) {
  const std::string two = "  - project: room\n  - {project: shelf, place: {same_poses: true}}\n";
  const Error without = error_of([&] { read(two); });
  EXPECT_EQ(without.detail().code, "NOT_SAME_POSES");
  EXPECT_NE(without.detail().where.find("scene.yaml:3:"), std::string::npos) << without.what();
  const Similarity room{2, rotation_matrix(Quatd{0.6, 0, 0, 0.8}), {1, 2, 3}},
      shelf{0.5, rotation_matrix(Quatd{0.8, 0.6, 0, 0}), {-1, 0, 4}};
  pose("room", "a", room);
  pose("shelf", "b", shelf);
  EXPECT_EQ(error_of([&] { read(two); }).detail().code, "NOT_SAME_POSES");
  pose("shelf", "a", shelf);
  const Similarity place = read(two)[1].place;
  for (const Vec3d& p : {Vec3d{0, 0, 0}, Vec3d{1, -2, 0.5}, Vec3d{3, 1, 1}})
    EXPECT_LT(length(place * (shelf * p) - room * p), 1e-12) << "a point of the common frame";
  for (const char* other : {"{same_poses: false}", "{same_poses: true, scale: 2}"})
    EXPECT_EQ(error_of([&] { read(fmt::format("  - project: room\n  - {{project: shelf, place: {}}}\n", other)); }).kind(),
              ErrorKind::Usage);
}

TEST_F(CompositionFile, TheKeyCoversTheArtifactsOfAllParts) {
  const auto files = composition_files(projects_.list("  - project: room\n  - project: shelf\n  - project: nowhere\n"));
  EXPECT_EQ(files.size(), 2 * test::Projects::balls().artifacts().size());
  for (const fs::path& file : files) EXPECT_TRUE(fs::exists(file)) << file;
}

}  // namespace
}  // namespace vitrine
