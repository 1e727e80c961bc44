#include "stages/mesh/mesh.h"

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/mesh/mesh_distance.h"
#include "core/scene/mesh/mesh_io.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/activation.h"
#include "core/scene/surfels/splat_scene.h"
#include "tests/core/scene/mesh/orbit.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

// A folder instead of the store, and a memory of what was said.
class FolderContext : public StageContext {
 public:
  FolderContext(std::map<std::string, fs::path> inputs, fs::path output)
      : inputs_(std::move(inputs)), output_(std::move(output)) {
    make_folders(output_);
  }
  fs::path input(std::string_view name) const override { return inputs_.at(std::string(name)); }
  std::optional<fs::path> optional_input(std::string_view name) const override {
    const auto it = inputs_.find(std::string(name));
    return it == inputs_.end() ? std::nullopt : std::optional(it->second);
  }
  const fs::path& output() const override { return output_; }
  const fs::path& scratch() const override { return output_; }
  int threads() const override { return 0; }
  size_t max_memory_bytes() const override { return 0; }
  void progress(const Progress& p) override {
    EXPECT_GE(p.fraction, last_fraction);
    last_fraction = p.fraction;
  }
  void metric(std::string_view name, double value) override { metrics[std::string(name)] = value; }
  void warning(std::string_view code, std::string_view) override { warnings.emplace_back(code); }
  void summary(std::string_view) override {}
  void timing(std::string_view, double) override {}

  double last_fraction = 0;
  std::map<std::string, double> metrics;
  std::vector<std::string> warnings;

 private:
  std::map<std::string, fs::path> inputs_;
  fs::path output_;
};

// A ball of radius 0.3 above a square table at z = -0.3: surfels on both, cameras around, sparse points on the surface.
class BallOnTable : public testing::Test {
 protected:
  void SetUp() override {
    Rng rng(1);
    std::vector<Vec3d> points, normals;
    for (int i = 0; i < 2500; ++i) {  // spiral: even over the sphere
      const double z = 1 - (2 * i + 1) / 2500.0, phi = 2.399963229728653 * i, r = std::sqrt(1 - z * z);
      normals.push_back({r * std::cos(phi), r * std::sin(phi), z});
      points.push_back(learnt_radius * normals.back());
    }
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 40; ++x) {
        points.push_back({(x + 0.5) / 40 - 0.5, (y + 0.5) / 40 - 0.5, -0.3});
        normals.push_back({0, 0, 1});
      }
    SplatLayer layer(LayerKind::Diffuse, 0, points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      const Vec3d n = normals[i], u = normalized(cross(n, std::abs(n.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
      const Quatd q = quaternion(Mat3d{u, cross(n, u), n});
      const double raw[4] = {q.w, q.x, q.y, q.z};
      for (size_t c = 0; c < 3; ++c) {
        layer.at(Attribute::Mean, i)[c] = float(points[i][c]);
        layer.at(Attribute::ShDc, i)[c] = ((c == 0 ? 0.8f : 0.2f) - 0.5f) / kShDc;  // red
      }
      for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = float(raw[c]);
      for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = std::log(0.014f);
      layer.at(Attribute::Opacity, i)[0] = logit(0.97f);
    }
    sfm = folder.path() / "sfm";
    optimize = folder.path() / "optimize";
    for (const fs::path& f : {sfm / "sparse" / "0", sfm / "sfm", optimize / "gaussians", optimize / "optimize"}) make_folders(f);
    write_layer(optimize / "gaussians" / "diffuse.ply", layer);

    views = orbit::views(10, {15, 50}, 1.1, 128);
    ColmapModel model;
    Gains gains;
    nlohmann::json names = nlohmann::json::array();
    for (size_t i = 0; i < views.size(); ++i) {
      const uint32_t id = static_cast<uint32_t>(i + 1);
      model.cameras.push_back(colmap_pinhole(id, views[i].intrinsics));
      model.images.push_back(
          {id, quaternion(views[i].cam_from_world.rotation), views[i].cam_from_world.translation, id, views[i].name, {}});
      gains[views[i].name] = {1, 1, 1};
      names.push_back(views[i].name);
    }
    for (size_t i = 0; i < points.size(); i += 3) model.points.push_back({i + 1, points[i], {}, 0, {}});
    for (uint64_t i = 0; i < 200; ++i)  // far walls, which are not what the cameras look at
      model.points.push_back({10000 + i, {6 + rng.uniform(), 8 * rng.uniform() - 4, 3 * rng.uniform()}, {}, 0, {}});
    write_colmap_model(sfm / "sparse" / "0", model, ColmapFormat::Binary);
    write_gains(sfm / "sfm" / "gains.json", gains);
    SceneInfo info;
    info.bounds = {{-1, -1, -1}, {1, 1, 1}};
    write_scene_info(sfm / "scene.json", info);
    write_views(names);
  }

  void write_views(const nlohmann::json& train) const {
    write_file(
        optimize / "optimize" / "views.json",
        nlohmann::json{{"train", train}, {"heldout", nlohmann::json::array()}, {"holdout_every", 0}, {"max_side", 0}}.dump());
  }

  nlohmann::json run(const std::string& name, const std::vector<std::pair<std::string, std::string>>& options = {}) {
    Stage stage = mesh_stage();
    stage.options.find("resolution")->assign("96", "test");
    for (const auto& [path, text] : options) stage.options.find(path)->assign(text, "test");
    out = folder.path() / name;
    std::map<std::string, fs::path> inputs{{"sfm", sfm}, {"optimize", optimize}};
    if (!objects.empty()) inputs["objects"] = objects;
    FolderContext context(inputs, out);
    stage.run(context);
    warnings = context.warnings;
    return nlohmann::json::parse(read_file(out / "mesh" / "report.json"));
  }

  TemporaryFolder folder;
  fs::path sfm, optimize, objects, out;
  double learnt_radius = 0.3;
  std::vector<View> views;
  std::vector<std::string> warnings;
};

TEST_F(BallOnTable, BecomesAMeshOfBothWithinTheVoxel) {
  const nlohmann::json report = run("a", {{"faces", "8000"}});
  EXPECT_EQ(report["region"]["kind"], "convergent");
  EXPECT_LT(report["region"]["high"][0].get<double>(), 0.7);  // the far walls are left out
  EXPECT_TRUE(warnings.empty());
  EXPECT_FALSE(fs::exists(out / "mesh/behind_glass.ply"));
  const double voxel = report["voxel"];
  EXPECT_NEAR(voxel, 1.1 / 96, 0.002);
  EXPECT_LE(report["mesh"]["faces"].get<size_t>(), 8000u);
  EXPECT_EQ(report["mesh"]["nonmanifold_edges"], 0);
  EXPECT_EQ(report["mesh"]["self_intersections"], 0);
  const TriMesh mesh = read_mesh_ply(out / "mesh" / "mesh.ply");
  EXPECT_EQ(mesh.faces.size(), report["mesh"]["faces"].get<size_t>());
  EXPECT_GT(read_mesh_ply(out / "mesh" / "mesh_raw.ply").faces.size(), mesh.faces.size());
  ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  // Completeness where cameras see it: the ball's upper part and the open table. Accuracy against the two shapes.
  const MeshDistance distance(mesh);
  Rng rng(2);
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    Vec3d n = normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()});
    n.z = std::abs(n.z);
    worst = std::max<double>(worst, distance.closest(cast<float>(0.3 * n)).distance);
    const double x = rng.uniform() - 0.5, y = rng.uniform() - 0.5;
    if (std::hypot(x, y) > 0.35 && std::max(std::abs(x), std::abs(y)) < 0.47)
      worst = std::max<double>(worst, distance.closest({float(x), float(y), -0.3f}).distance);
  }
  EXPECT_LT(worst, 2 * voxel);
  double mean = 0, red = 0;
  const SurfaceSamples samples = sample_surface(mesh, 5000, 1);
  for (const Vec3f& p : samples.positions) mean += std::min(std::abs(length(p) - 0.3f), std::abs(p.z + 0.3f)) / 5000;
  EXPECT_LT(mean, 0.5 * voxel);
  for (const Vec3f& c : mesh.colors) red += (c.x > 2 * c.y) / double(mesh.colors.size());
  EXPECT_GT(red, 0.95);
}

// What `mesh.method` gives: the ball on its table as a plinth.
void expect_closed_plinth(const TriMesh& mesh, const nlohmann::json& figures, double voxel) {
  const MeshReport r = mesh_report(mesh);
  EXPECT_TRUE(r.closed());
  EXPECT_EQ(r.manifold_edges, r.edges);
  EXPECT_EQ(figures["faces"].get<size_t>(), mesh.faces.size());
  EXPECT_EQ(figures["boundary_edges"], 0);
  EXPECT_EQ(figures["self_intersections"], 0);
  EXPECT_EQ(figures["seen_from_inside"], false);
  EXPECT_GT(figures["volume"].get<double>(), 0.1);  // of the upper half of the ball, and more
  EXPECT_GT(figures["fusion"]["boundary_edges"].get<size_t>(), 0u);
  EXPECT_LT(figures["distance_from_fusion"].get<double>(), voxel);
  EXPECT_GT(figures["invented_share"].get<double>(), 0.2);  // the lower side of the table
  ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  const MeshDistance distance(mesh);
  Rng rng(2);
  double worst = 0;
  for (int i = 0; i < 500; ++i) {
    Vec3d n = normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()});
    n.z = std::abs(n.z);
    worst = std::max<double>(worst, distance.closest(cast<float>(0.3 * n)).distance);
  }
  EXPECT_LT(worst, 2 * voxel);
}

TEST_F(BallOnTable, IsClosedByAPoissonSurface) {
  const nlohmann::json both = run("both", {{"method", "both"}, {"resolution", "48"}, {"faces", "6000"}});
  EXPECT_TRUE(warnings.empty());
  const double voxel = both["voxel"];
  EXPECT_FALSE(both["mesh"]["closed"].get<bool>());
  const TriMesh closed = read_mesh_ply(out / "mesh/watertight.ply");
  expect_closed_plinth(closed, both["watertight"], voxel);
  EXPECT_LE(closed.faces.size(), 6000u);
  const std::string fused = read_file(out / "mesh/mesh.ply");

  set_thread_limit(3);  // the same surface as mesh.ply, for any number of threads
  const nlohmann::json poisson = run("poisson", {{"method", "poisson"}, {"resolution", "48"}, {"faces", "6000"}});
  set_thread_limit(0);
  EXPECT_FALSE(fs::exists(out / "mesh/watertight.ply"));
  EXPECT_TRUE(poisson["mesh"]["closed"].get<bool>());
  EXPECT_TRUE(read_file(out / "mesh/mesh.ply") == read_file(folder.path() / "both/mesh/watertight.ply"));
  EXPECT_EQ(poisson["watertight"], both["watertight"]);

  const nlohmann::json fusion = run("fusion", {{"resolution", "48"}, {"faces", "6000"}});
  EXPECT_FALSE(fusion.contains("watertight"));
  EXPECT_TRUE(read_file(out / "mesh/mesh.ply") == fused) << "`both` leaves mesh.ply as it is";
}

TEST_F(BallOnTable, KeepsTheFusedMeshWhereThereIsNoClosedOne) {
  const std::vector<std::pair<std::string, std::string>> few = {{"resolution", "16"}, {"faces", "60"}};  // 30 points
  auto options = few;
  options.emplace_back("method", "both");
  const nlohmann::json report = run("few", options);
  EXPECT_EQ(warnings, std::vector<std::string>{"NOT_CLOSED"});
  EXPECT_FALSE(report.contains("watertight"));
  EXPECT_FALSE(fs::exists(out / "mesh/watertight.ply"));
  EXPECT_GT(read_mesh_ply(out / "mesh/mesh.ply").faces.size(), 0u);
  options.back().second = "poisson";
  try {
    run("none", options);
    FAIL() << "30 points are too few";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().code, "NOT_CLOSED");
    EXPECT_NE(e.detail().why.find("at least 100"), std::string::npos);
  }
}

TEST(MeshCost, OfAClosedMeshIsMore) {
  CostTerms terms;
  terms.options = {{"mesh.resolution", "256"}, {"mesh.faces", "200000"}, {"mesh.method", "fusion"}};
  const StageCost fusion = mesh_cost(terms);
  terms.options["mesh.method"] = "both";
  const StageCost both = mesh_cost(terms);
  EXPECT_GT(both.cpu_s, fusion.cpu_s);
  EXPECT_GT(both.memory_bytes, fusion.memory_bytes);
  EXPECT_EQ(both.disk_bytes, 2 * fusion.disk_bytes);
}

// A polished ball: the surfels stand where the mirrored things appear, deep inside; its shape is known.
class MirrorOnTable : public BallOnTable {
 protected:
  MirrorOnTable() { learnt_radius = 0.2; }
  nlohmann::json run_as(ObjectRole role, ObjectTrust trust = ObjectTrust::Given) {
    const fs::path masks = folder.path() / "masks";
    for (const View& view : views) {
      const Intrinsics& k = view.intrinsics;
      const Vec3d eye = view.centre_in_world();
      Image8 mask(k.width, k.height, 1);
      for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x) {
          const Vec3d d = normalized(view.ray(x + 0.5, y + 0.5));
          mask.at(x, y) = length(eye - dot(eye, d) * d) < 0.3 ? 255 : 0;
        }
      make_folders(masks / "masks" / "specular");
      write_ldr(masks / "masks" / "specular" / (view.stem() + ".png"), mask);
    }
    SurfaceOfRevolution ball{{0, 0, 0}, {0, 0, 1}, {}};
    for (int i = 0; i <= 48; ++i)
      ball.profile.push_back({0.3 * std::sin(std::numbers::pi * i / 48), -0.3 * std::cos(std::numbers::pi * i / 48)});
    ObjectSet set = test::one_object(ball, role, 0.02);
    set.objects[0].trust = trust;
    objects = test::write_objects_artifact(folder.path() / "objects", masks, views, set);
    return run(std::string(name(role)) + " " + std::string(name(trust)), {{"resolution", "64"}});
  }
  // Worst distance of the ball's upper part from the mesh.
  double worst() const {
    const MeshDistance distance(read_mesh_ply(out / "mesh" / "mesh.ply"));
    double worst = 0;
    Rng rng(3);
    for (int i = 0; i < 1000; ++i) {
      Vec3d n = normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()});
      n.z = std::abs(n.z);
      worst = std::max<double>(worst, distance.closest(cast<float>(0.3 * n)).distance);
    }
    return worst;
  }
};

TEST_F(MirrorOnTable, HasTheShapeOfItsObject) {
  run_as(ObjectRole::Mirror);
  EXPECT_LT(worst(), 0.02);
  const TriMesh mesh = read_mesh_ply(out / "mesh" / "mesh.ply");
  double angle = 0, count = 0;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (mesh.positions[v].z < 0) continue;
    angle += std::acos(std::clamp(dot(mesh.normals[v], normalized(mesh.positions[v])), -1.f, 1.f)) * 57.29578;
    count += 1;
  }
  fmt::print("normals {:.1f} deg off, worst distance {:.3f}\n", angle / count, worst());
  EXPECT_LT(angle / count, 3);
}

TEST_F(MirrorOnTable, WithoutItsObjectIsWhatWasLearnt) {
  run("without", {{"resolution", "64"}});
  EXPECT_GT(worst(), 0.09);
  run_as(ObjectRole::Mirror, ObjectTrust::Guessed);
  EXPECT_GT(worst(), 0.09) << "a guess is no depth";
  run_as(ObjectRole::Coat);
  EXPECT_GT(worst(), 0.09) << "paint keeps the depth that was learnt";
}

// The ball under five panes: the diffuse layer has panes and table, the ball is in the transmittance layer.
class BallInACase : public BallOnTable {
 protected:
  static constexpr float kHalf = 0.36f, kTop = 0.38f, kFloor = -0.3f;
  void SetUp() override {
    BallOnTable::SetUp();
    const fs::path file = optimize / "gaussians/diffuse.ply";
    const SplatLayer both = read_layer(file);
    const size_t ball = 2500, table = both.size() - ball;
    SplatLayer shell(LayerKind::Diffuse, 0, table), content(LayerKind::Transmittance, 0, ball);
    for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc}) {
      std::copy_n(both.at(a, 0), ball * both.width(a), content.at(a, 0));
      std::copy_n(both.at(a, ball), table * both.width(a), shell.at(a, 0));
    }
    for (size_t i = 0; i < table; ++i) *shell.at(Attribute::Transmission, i) = logit(0.01f);
    const auto pane = [&](const Vec3f& centre, const Vec3f& a, const Vec3f& b) {
      constexpr int kSide = 30;
      const Vec3f n = normalized(cross(a, b));
      const Quatf q = quaternion(Mat3f{normalized(a), cross(n, normalized(a)), n});
      for (int k = 0; k < kSide * kSide; ++k) {
        const size_t i = shell.size();
        shell.resize(i + 1);
        const Vec3f p =
            centre + (2 * (float(k % kSide) + 0.5f) / kSide - 1) * a + (2 * (float(k / kSide) + 0.5f) / kSide - 1) * b;
        for (size_t c = 0; c < 3; ++c) shell.at(Attribute::Mean, i)[c] = p[c], shell.at(Attribute::ShDc, i)[c] = -0.5f / kShDc;
        const float raw[4] = {q.w, q.x, q.y, q.z};
        std::copy_n(raw, 4, shell.at(Attribute::Rotation, i));
        for (size_t c = 0; c < 2; ++c) shell.at(Attribute::LogScale, i)[c] = std::log(0.014f);
        *shell.at(Attribute::Opacity, i) = logit(0.97f);
        *shell.at(Attribute::Transmission, i) = logit(0.95f);
      }
    };
    const float middle = (kTop + kFloor) / 2, high = (kTop - kFloor) / 2;
    for (const float side : {-1.f, 1.f}) {
      pane({side * kHalf, 0, middle}, {0, side * kHalf, 0}, {0, 0, high});
      pane({0, side * kHalf, middle}, {-side * kHalf, 0, 0}, {0, 0, high});
    }
    pane({0, 0, kTop}, {kHalf, 0, 0}, {0, kHalf, 0});
    write_layer(file, shell);
    write_layer(optimize / "gaussians/transmittance.ply", content);
  }
};

TEST_F(BallInACase, HasAMeshOfItsOwnBehindTheGlass) {
  const nlohmann::json report = run("case");
  const double voxel = report["voxel"];
  ASSERT_TRUE(report.contains("behind_glass"));
  const TriMesh mesh = read_mesh_ply(out / "mesh/mesh.ply"), behind = read_mesh_ply(out / "mesh/behind_glass.ply");
  ASSERT_EQ(behind.normals.size(), behind.positions.size());
  const MeshDistance to_mesh(mesh), to_behind(behind);
  Rng rng(4);
  double worst = 0, nearest = 1;
  for (int i = 0; i < 1000; ++i) {
    Vec3d n = normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()});
    n.z = std::abs(n.z);
    if (n.z < 0.2) continue;  // the table comes near
    worst = std::max<double>(worst, to_behind.closest(cast<float>(0.3 * n)).distance);
    nearest = std::min<double>(nearest, to_mesh.closest(cast<float>(0.3 * n)).distance);
  }
  EXPECT_LT(worst, 2 * voxel);
  EXPECT_GT(nearest, 2 * voxel);  // mesh.ply ends at the panes
  double off = 0, pane = 0;
  for (const Vec3f& p : sample_surface(behind, 3000, 1).positions) {
    off += std::min(std::abs(length(p) - 0.3f), std::abs(p.z + 0.3f)) / 3000;
    pane += (p.z > 0 && std::max(std::abs(p.x), std::abs(p.y)) > kHalf - float(voxel)) / 3000.0;
  }
  EXPECT_LT(off, 0.5 * voxel);
  EXPECT_EQ(pane, 0);
  for (const Vec3f& c : behind.colors) ASSERT_GT(c.x, c.y);  // red, not the panes' black
}

TEST_F(BallOnTable, GivesTheSameBytesForAnyNumberOfThreads) {
  for (int threads : {1, 8}) {
    set_thread_limit(threads);
    run(threads == 1 ? "one" : "many", {{"resolution", "48"}});
  }
  set_thread_limit(0);
  for (const char* file : {"mesh_raw.ply", "mesh.ply", "report.json"})
    EXPECT_EQ(read_file(folder.path() / "one" / "mesh" / file), read_file(folder.path() / "many" / "mesh" / file)) << file;
}

TEST_F(BallOnTable, EnlargesTheVoxelRatherThanTheMemory) {
  const nlohmann::json report = run("small", {{"fusion.memory_mb", "4"}, {"resolution", "128"}});
  EXPECT_LE(report["volume_bytes"].get<size_t>(), size_t(4) << 20);
  EXPECT_GT(report["volume_bytes"].get<size_t>(), size_t(2) << 20);
  EXPECT_EQ(warnings, std::vector<std::string>{"VOXEL_ENLARGED"});
}

TEST_F(BallOnTable, TakesABoxAndSaysWhenItIsEmpty) {
  Stage stage = mesh_stage();
  stage.options.find("region.box")->assign_list({"3", "3", "3", "4", "4", "4"}, "test");
  FolderContext context({{"sfm", sfm}, {"optimize", optimize}}, folder.path() / "empty");
  try {
    stage.run(context);
    FAIL() << "a box beside the scene has no surface";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_EQ(e.detail().code, "NO_SURFACE");
  }
}

TEST_F(BallOnTable, RefusesViewsThatTheSfmArtifactDoesNotHave) {
  write_views({"view_100.png", "other.png"});
  try {
    run("bad");
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(e.detail().why.find("other.png"), std::string::npos);
  }
  write_file(optimize / "optimize" / "views.json", "{\"train\": 3}");
  EXPECT_THROW(run("worse"), Error);
}

}  // namespace
}  // namespace vitrine
