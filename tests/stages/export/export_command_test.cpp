// `vitrine export` on a finished project: where files go, and what it must not overwrite.
#include <cstdlib>

#include <gtest/gtest.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/json.h"
#include "pipeline/commands.h"
#include "pipeline/project.h"
#include "stages/export/export.h"
#include "tests/stages/export/pane_scene.h"
#include "tests/stages/export/ring_of_cameras.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

class ExportCommand : public testing::Test {
 protected:
  ExportCommand() {
    setenv("VITRINE_STAGE_DIR", VITRINE_BIN_DIR, 1);
    const TemporaryFolder artifacts;
    test::PaneScene().write(artifacts.path());
    write_colmap_model(artifacts.path() / "sfm/sparse/0", test::ring_of_cameras(), ColmapFormat::Binary);
    write_file(project() / "vitrine.yaml", "");
    ArtifactStore store(store_of(project()));
    for (const char* stage : {"sfm", "optimize", "mesh"}) {
      const std::string key = std::string(32, stage[0]);
      PendingArtifact pending(store, stage, key);
      fs::copy(artifacts.path() / stage, pending.path(), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
      Manifest manifest;
      manifest.stage = stage;
      manifest.key = key;
      pending.commit(manifest, "{}");
      set_current_key(project(), stage, key);
    }
  }
  ~ExportCommand() override { unsetenv("VITRINE_STAGE_DIR"); }

  const fs::path& project() const { return folder_.path(); }
  int run(Words words) const {
    words.insert(words.begin(), {project().string(), "--quiet", "--no-progress", "--set", "texture_size=64"});
    return export_command(words);
  }

  // What the export stage of a run leaves; the formats that it left alone.
  std::vector<std::string> run_writes(const std::string& key, const ExportConfig& config) const {
    ArtifactStore store(store_of(project()));
    test::RecordingContext context({{"sfm", store.entry("sfm", std::string(32, 's'))},
                                    {"optimize", store.entry("optimize", std::string(32, 'o'))},
                                    {"mesh", store.entry("mesh", std::string(32, 'm'))}});
    run_export(config, context);
    PendingArtifact pending(store, "export", key);
    fs::copy(context.output(), pending.path(), fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    Manifest manifest;
    manifest.stage = "export", manifest.key = key;
    pending.commit(manifest, "{}");
    const auto last = current_key(project(), "export");
    const auto before = last ? store.find("export", *last) : std::nullopt;
    const auto kept = publish_export(store.entry("export", key), manifest, project(), before ? &*before : nullptr);
    set_current_key(project(), "export", key);
    return kept;
  }

  TemporaryFolder folder_;
};

TEST_F(ExportCommand, WritesNothingAmongThePhotos) {
  const fs::path photos = project() / "my photos", link = project() / "link";
  make_folders(photos);
  fs::create_directory_symlink(photos, link);
  write_file(project() / "vitrine.yaml", "input:\n  photos: \"" + photos.string() + "\"\n");
  for (const fs::path& target : {photos, photos / "export", link / "export"}) {
    const Error e = error_of([&] { run({"--formats", "mesh-obj", "-o", target.string()}); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage) << target;
  }
  EXPECT_TRUE(fs::is_empty(photos));
}

TEST_F(ExportCommand, WritesTheFormatsAskedForIntoTheProject) {
  EXPECT_EQ(run({"--formats", "mesh-glb,mesh-ply"}), 0);
  EXPECT_TRUE(fs::exists(project() / "export/mesh.glb"));
  EXPECT_TRUE(fs::exists(project() / "export/mesh.ply"));
  EXPECT_FALSE(fs::exists(project() / "export/mesh.obj"));
  // Another export adds to what is there, and to the report.
  EXPECT_EQ(run({"--formats", "mesh-obj"}), 0);
  const auto report = nlohmann::json::parse(read_file(project() / "export/formats.json"));
  ASSERT_EQ(report.size(), 3u);
  EXPECT_EQ(report[2]["format"], "mesh-obj");
  EXPECT_EQ(run({"--formats", "mesh-obj"}), 0) << "the same files again are no conflict";
}

TEST_F(ExportCommand, OverwritesNothingUnlessTold) {
  EXPECT_EQ(run({"--formats", "mesh-obj,mesh-ply"}), 0);
  const std::string before = read_file(project() / "export/mesh.ply");
  write_file(project() / "export/mesh.obj", "my own");
  const Error e = error_of([&] { run({"--formats", "mesh-ply,mesh-obj", "--axes", "rhyu"}); });
  EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_EQ(e.detail().code, "EXPORT_EXISTS");
  EXPECT_NE(std::string(e.what()).find("mesh.obj"), std::string::npos);
  EXPECT_EQ(read_file(project() / "export/mesh.ply"), before);
  EXPECT_EQ(read_file(project() / "export/mesh.obj"), "my own");
  EXPECT_EQ(run({"--formats", "mesh-ply,mesh-obj", "--axes", "rhyu", "--overwrite"}), 0);
  EXPECT_NE(read_file(project() / "export/mesh.ply"), before);
  EXPECT_NE(read_file(project() / "export/mesh.obj"), "my own");
}

TEST_F(ExportCommand, TakesItsUnitFromAScaleBar) {
  const Vec3d ends[2] = {{-0.1, 0.05, 0}, {0.1, 0.2, 0.05}};
  const std::string bar = test::marked_bar(test::ring_of_cameras(), ends) + " = 5.1 cm";
  EXPECT_EQ(run({"--formats", "mesh-obj", "--scale-bar", bar}), 0);
  const auto report = nlohmann::json::parse(read_file(project() / "export/formats.json"));
  EXPECT_NE(report[0].at("notes").dump().find("one unit of the scene is 0.2 m, by the scale bar"), std::string::npos) << report;
  EXPECT_EQ(error_of([&] { run({"--scale-bar", "ring 0.jpg:1,2,3,4 = 5cm"}); }).detail().code, "SCALE_BAR");
  EXPECT_EQ(error_of([&] { run({"--scale-bar", bar, "--scale", "24cm"}); }).kind(), ErrorKind::Usage);
  EXPECT_EQ(error_of([&] { run({"--scale-bar", bar, "--scale-points", "0,0,0 1,0,0 1m"}); }).kind(), ErrorKind::Usage);
  EXPECT_EQ(error_of([&] { run({"--scale-points", "0,0,0 1,0,0"}); }).detail().code, "SCALE_POINTS");
  EXPECT_EQ(run({"--formats", "mesh-obj", "--scale-points", "-0.4,0,0 0,0,0 8cm", "--overwrite"}), 0);
  EXPECT_NE(read_file(project() / "export/formats.json").find("one unit of the scene is 0.2 m, by two points"),
            std::string::npos);
  EXPECT_EQ(run({"--formats", "mesh-obj", "--scale-bar", "nowhere.jpg:1,2,3,4 ring 0.jpg:1,2,3,4 = 5cm", "--overwrite"}), 2);
}

TEST_F(ExportCommand, AReportThatIsNotItsOwnIsInTheWay) {
  for (const char* foreign : {"my notes", "[{\"format\": 3, \"files\": []}]", "[1]", "{}", "[{\"format\": \"mesh-obj\"}]"}) {
    write_file(project() / "export/formats.json", foreign);
    const Error e = error_of([&] { run({"--formats", "mesh-ply"}); });
    EXPECT_EQ(e.detail().code, "EXPORT_EXISTS") << foreign;
    EXPECT_NE(std::string(e.what()).find("formats.json"), std::string::npos);
    EXPECT_EQ(read_file(project() / "export/formats.json"), foreign);
    EXPECT_FALSE(fs::exists(project() / "export/mesh.ply"));
  }
  EXPECT_EQ(run({"--formats", "mesh-ply", "--overwrite"}), 0);
  EXPECT_EQ(nlohmann::json::parse(read_file(project() / "export/formats.json"))[0]["format"], "mesh-ply");
}

TEST_F(ExportCommand, ARunLeavesAloneWhatWasAskedFor) {
  const auto formats = [&] {
    std::vector<std::string> names;
    for (const auto& f : nlohmann::json::parse(read_file(project() / "export/formats.json"))) names.push_back(f["format"]);
    return names;
  };
  using Names = std::vector<std::string>;
  const std::string first(32, '1'), second(32, '2');
  EXPECT_EQ(run_writes(first, {.formats = {"mesh-ply", "mesh-obj", "ply-2dgs"}, .texture_size = 64}), Names{});
  const std::string mesh_of_run = read_file(project() / "export/mesh.ply");
  EXPECT_EQ(run({"--formats", "mesh-ply"}), 0);
  EXPECT_EQ(run_writes(first, {.formats = {"mesh-ply", "mesh-obj", "ply-2dgs"}, .texture_size = 64}), Names{})
      << "the same files are nobody's wish";
  // Asked for: a mesh of another size, a file that the run has not.
  EXPECT_EQ(run({"--formats", "mesh-ply,ply-3dgs", "--scale", "24cm", "--overwrite"}), 0);
  const std::string asked = read_file(project() / "export/mesh.ply"), splats = read_file(project() / "export/gaussians_3dgs.ply");
  EXPECT_NE(asked, mesh_of_run);
  // The same run again, and one with other options.
  for (const auto& [key, axes] : {std::pair{first, ExportAxes::Rhzu}, {second, ExportAxes::Rhyu}}) {
    EXPECT_EQ(run_writes(key, {.formats = {"mesh-ply", "mesh-obj", "ply-2dgs"}, .axes = axes, .texture_size = 64}),
              Names{"mesh-ply"});
    EXPECT_EQ(read_file(project() / "export/mesh.ply"), asked);
    EXPECT_EQ(read_file(project() / "export/gaussians_3dgs.ply"), splats);
    EXPECT_EQ(read_file(project() / "export/mesh.obj"),
              read_file(ArtifactStore(store_of(project())).entry("export", key) / "export/mesh.obj"));
    EXPECT_EQ(formats(), (Names{"mesh-ply", "mesh-obj", "ply-2dgs", "ply-3dgs"}));
  }
  // Deleted: the run writes its own again.
  fs::remove(project() / "export/mesh.ply");
  fs::remove(project() / "export/gaussians_3dgs.ply");
  EXPECT_EQ(run_writes(first, {.formats = {"mesh-ply", "mesh-obj", "ply-2dgs"}, .texture_size = 64}), Names{});
  EXPECT_EQ(read_file(project() / "export/mesh.ply"), mesh_of_run);
  EXPECT_EQ(formats(), (Names{"mesh-ply", "mesh-obj", "ply-2dgs"}));
}

// OBJ and USD have textures of the same names on charts that may differ.
TEST_F(ExportCommand, FormatsDoNotShareFiles) {
  using Names = std::vector<std::string>;
  const std::string first(32, '1'), second(32, '2');
  EXPECT_EQ(run_writes(first, {.formats = {"mesh-obj"}, .texture_size = 64}), Names{});
  const std::string texture = read_file(project() / "export/textures/obj/base_color.png");
  EXPECT_EQ(run({"--formats", "mesh-usd", "--set", "texture_size=128"}), 0) << "nothing is in the way";
  EXPECT_EQ(read_file(project() / "export/textures/obj/base_color.png"), texture);
  const std::string asked = read_file(project() / "export/textures/usd/base_color.png");
  EXPECT_NE(asked, texture);
  // Asked for was USD, so a later run writes its OBJ anew, and leaves the USD.
  EXPECT_EQ(run_writes(second, {.formats = {"mesh-obj", "mesh-usd"}, .axes = ExportAxes::Rhyu, .texture_size = 32}),
            Names{"mesh-usd"});
  EXPECT_NE(read_file(project() / "export/textures/obj/base_color.png"), texture);
  EXPECT_EQ(read_file(project() / "export/textures/usd/base_color.png"), asked);
}

TEST_F(ExportCommand, AnotherFolderAndAUnitOfLength) {
  const fs::path out = project() / "for blender";
  EXPECT_EQ(run({"--formats", "mesh-obj", "-o", out.string(), "--scale", "50cm"}), 0);
  EXPECT_TRUE(fs::exists(out / "textures/obj/base_color.png"));
  EXPECT_FALSE(fs::exists(project() / "export"));
  EXPECT_NE(read_file(out / "mesh.obj").find("v -0.5 -0.5 0\n"), std::string::npos);
}

TEST_F(ExportCommand, BadCallsAreUsageErrors) {
  for (const Words& words : {Words{"--scale", "a foot"}, Words{"--scale", "-1"}, Words{"--scale", "3 miles"}, Words{"--format"}})
    EXPECT_EQ(error_of([&] { run(words); }).kind(), ErrorKind::Usage);
  EXPECT_EQ(run({"--axes", "up"}), exit_code(ErrorKind::Usage));
  const Error format = error_of([&] { run({"--formats", "ply-3dgs,mesh-glbb"}); });
  EXPECT_EQ(format.kind(), ErrorKind::Usage);
  EXPECT_EQ(format.message(), "there is no format 'mesh-glbb'; did you mean 'mesh-glb'?");
  EXPECT_FALSE(fs::exists(project() / "export"));
}

TEST_F(ExportCommand, AProjectWithoutAMeshSaysSo) {
  write_file(store_of(project()) / "current.json", "{}");
  set_current_key(project(), "sfm", std::string(32, 's'));
  set_current_key(project(), "optimize", std::string(32, 'o'));
  const Error e = error_of([&] { run({}); });
  EXPECT_EQ(e.kind(), ErrorKind::Input);
  EXPECT_NE(std::string(e.what()).find("'mesh'"), std::string::npos);
}

TEST(FormatTable, SaysWhatEveryFormatHoldsAndLoses) {
  const std::string table = format_table();
  for (const std::string& name : ExportConfig{}.formats) EXPECT_NE(table.find(name + "  "), std::string::npos);
  EXPECT_NE(table.find("loses"), std::string::npos);
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100u) << line;
}

}  // namespace
}  // namespace vitrine
