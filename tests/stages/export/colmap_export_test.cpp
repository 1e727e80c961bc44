#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/mesh/mesh_io.h"
#include "stages/export/export.h"
#include "tests/core/scene/camera/tiny_model.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

class ColmapExport : public testing::Test {
 protected:
  ColmapExport()
      : model_(test::tiny_model()),
        context_({{"sfm", root_.path() / "sfm"}, {"optimize", root_.path() / "optimize"}, {"mesh", root_.path() / "mesh"}}) {
    make_folders(root_.path() / "sfm/sparse/0");
    make_folders(root_.path() / "optimize/optimize");
    make_folders(root_.path() / "mesh/mesh");
    TriMesh triangle;
    triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    triangle.faces = {{0, 1, 2}};
    write_mesh_ply(root_.path() / "mesh/mesh/mesh.ply", triangle);
    for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text})
      write_colmap_model(root_.path() / "sfm/sparse/0", model_, format);
    for (const ColmapImage& image : model_.images) {
      make_folders((root_.path() / "sfm/images" / image.name).parent_path());
      write_file(root_.path() / "sfm/images" / image.name, "photo " + image.name);
    }
    write_scene_info(root_.path() / "sfm/scene.json", {});
  }
  fs::path exported() {
    run_export({.formats = {"colmap"}}, context_);
    return context_.output() / "export/colmap";
  }

  TemporaryFolder root_;
  ColmapModel model_;
  test::RecordingContext context_;
};

TEST_F(ColmapExport, IsACopyOfTheModel) {
  const fs::path out = exported();
  for (const ColmapImage& image : model_.images) EXPECT_EQ(read_file(out / "images" / image.name), "photo " + image.name);
  // Independent of our reader: u64 count, then u32 id, i32 model, u64 width, u64 height of the first camera.
  const std::string bytes = read_file(out / "sparse/0/cameras.bin");
  uint64_t count = 0, width = 0;
  uint32_t id = 0;
  std::memcpy(&count, bytes.data(), 8);
  std::memcpy(&id, bytes.data() + 8, 4);
  std::memcpy(&width, bytes.data() + 16, 8);
  EXPECT_EQ(count, 3u);
  EXPECT_EQ(id, 1u);
  EXPECT_EQ(width, 640u);
  for (const char* part : {"cameras.txt", "images.txt", "points3D.txt", "images.bin", "points3D.bin"})
    EXPECT_EQ(read_file(out / "sparse/0" / part), read_file(root_.path() / "sfm/sparse/0" / part)) << part;
  EXPECT_TRUE(fs::exists(out / "scene.json"));
}

TEST_F(ColmapExport, HasThePosesThatTrainingCorrected) {
  Rigid moved = model_.images[1].cam_from_world();
  moved.translation.x += 0.125;
  moved.rotation = rotation_matrix(normalized(Quatd{1, 0, 0.01, 0})) * moved.rotation;
  write_corrected_poses(root_.path() / "optimize", {{.name = model_.images[1].name, .cam_from_world = moved}});
  const fs::path out = exported();
  for (const ColmapFormat format : {ColmapFormat::Binary, ColmapFormat::Text}) {
    const ColmapModel found = read_colmap_model(out / "sparse/0", format);
    ASSERT_EQ(found.images.size(), model_.images.size());
    EXPECT_EQ(found.points.size(), model_.points.size());
    for (size_t i = 0; i < found.images.size(); ++i) {
      const Rigid want = i == 1 ? moved : model_.images[i].cam_from_world(), have = found.images[i].cam_from_world();
      EXPECT_NEAR(length(have.translation - want.translation), 0, 1e-9) << i;
      for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(length(have.rotation.column(k) - want.rotation.column(k)), 0, 1e-9) << i;
    }
  }
}

}  // namespace
}  // namespace vitrine
