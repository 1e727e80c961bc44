// A ball in a ball of glass, seen by eight cameras: what is wrong behind the glass is put right, what is right stays as it is,
// and a damaged mesh does no harm.
#include "stages/refine/refine.h"

#include <gtest/gtest.h>

#include "core/scene/image/ldr.h"
#include "core/render/picture/view_picture.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

using Json = nlohmann::json;

constexpr double kGlass = test::TinyCapture::kRadius, kInner = 0.2;

SplatLayer of_kind(LayerKind kind, const SplatLayer& from) {
  SplatLayer to(kind, from.sh_degree(), from.size());
  for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
    std::ranges::copy(from.values(a), to.values(a).begin());
  return to;
}

class GlassBall : public ::testing::Test {
 protected:
  GlassBall() {
    scene.surfels.diffuse = of_kind(LayerKind::Diffuse, test::sphere_layer(kGlass));
    std::ranges::fill(scene.surfels.diffuse.values(Attribute::Transmission), 6.f);
    std::ranges::fill(scene.surfels.diffuse.values(Attribute::SpecularWeight), -6.f);
    scene.surfels.transmittance = of_kind(LayerKind::Transmittance, test::sphere_layer(kInner));
    scene.image.transmission.glass = Glass::Thin;
    scene.image.diffuse.sh_degree = scene.image.transmission.sh_degree = 0;
    take_photos();
    make_folders(masks() / "masks/transparent");
    Image8 mask(test::TinyCapture::kWidth, test::TinyCapture::kHeight, 1);
    for (const View& v : capture.views) {
      for (int y = 0; y < mask.height(); ++y)
        for (int x = 0; x < mask.width(); ++x) {
          const Vec3d d = transposed_times(v.cam_from_world.rotation, normalized(v.intrinsics.ray(x + 0.5, y + 0.5)));
          const Vec3d o = v.centre_in_world(), nearest = o - dot(o, d) * d;
          mask.at(x, y) = length(nearest) < kGlass ? 255 : 0;
        }
      write_ldr(masks() / "masks/transparent" / (v.stem() + ".png"), mask);
    }
    test::write_objects_artifact(masks(), masks(), capture.views);
    write_file(capture.mesh() / "mesh/grid.json", R"({"voxel": 0.02})");
    write_scene();
  }

  // What the scene shows now is what the photos show.
  void take_photos() {
    ScenePainter painter(scene, {.layers = true});
    for (const View& v : capture.views) {
      ImageF photo = *painter.picture(v).layer("radiance");
      for (size_t i = 0; i < photo.data().size(); ++i) photo.data()[i] *= float(v.gain[i % 3]);
      write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
    }
  }
  void write_scene() {
    write_layer(capture.optimize() / "gaussians/diffuse.ply", scene.surfels.diffuse);
    write_layer(capture.optimize() / "gaussians/transmittance.ply", scene.surfels.transmittance);
    write_image_options(capture.optimize() / "optimize/model.json", scene.image);
  }
  // Dark surfels that hang between the cameras and the glass, facing the middle.
  void add_strays() {
    SplatLayer& layer = scene.surfels.transmittance;
    const SplatLayer shell = test::sphere_layer(0.66, 60);
    const size_t first = layer.size();
    layer.resize(first + shell.size());
    for (size_t i = 0; i < shell.size(); ++i) {
      for (Attribute a : {Attribute::Mean, Attribute::Rotation})
        std::copy_n(shell.at(a, i), shell.width(a), layer.at(a, first + i));
      for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, first + i)[c] = std::log(0.03f);
      for (size_t c = 0; c < 3; ++c) layer.at(Attribute::ShDc, first + i)[c] = -1.7f;
      *layer.at(Attribute::Opacity, first + i) = 2;
    }
    write_scene();
  }
  Json run(test::RecordingContext& context, int iterations = 0) {
    RefineConfig config;
    config.fine_tune.iterations = iterations;
    config.fine_tune.unchanged = true;
    config.fine_tune.checkpoint_every = 3;
    run_refine(config, context);
    return Json::parse(read_file(context.output() / "refine/report.json"));
  }
  std::map<std::string, fs::path> inputs() const {
    auto in = capture.inputs(false);
    in["masks"] = in["objects"] = masks();
    return in;
  }
  fs::path masks() const { return root.path() / "masks"; }

  test::TinyCapture capture;
  TemporaryFolder root;
  TrainedScene scene;
};

TEST_F(GlassBall, LosesWhatHangsInEmptySpace) {
  const size_t right = scene.surfels.transmittance.size();
  add_strays();
  test::RecordingContext context(inputs());
  const Json report = run(context);
  EXPECT_EQ(report.at("state"), "refined") << report.dump(1);
  EXPECT_GT(report.at("after").at("glass").get<double>(), report.at("before").at("glass").get<double>() + 3) << report.dump(1);
  EXPECT_GT(report.at("segments").at("closed").get<double>(), 0.85);
  EXPECT_TRUE(fs::exists(context.output() / "refine/segments.png"));
  const TrainedScene refined = read_trained_scene(capture.optimize(), context.output());
  EXPECT_LT(refined.surfels.transmittance.size(), right + 25);
  EXPECT_GE(refined.surfels.transmittance.size(), right - 5);  // nothing of the ball inside
  EXPECT_EQ(refined.surfels.diffuse, scene.surfels.diffuse);
  EXPECT_EQ(refined.image.transmission.glass, Glass::Thin);

  // The same bytes on one thread.
  const std::string chosen = read_file(context.output() / "refine/gaussians/transmittance.ply");
  set_thread_limit(1);
  test::RecordingContext alone(inputs());
  EXPECT_EQ(run(alone), report);
  EXPECT_EQ(read_file(alone.output() / "refine/gaussians/transmittance.ply"), chosen);
  set_thread_limit(0);
}

// A scene that was trained inside the masks of its object holds nothing else: a bright room around it is no error.
TEST_F(GlassBall, MeasuresAnObjectThatWasTrainedAloneInsideItsMasks) {
  make_folders(masks() / "masks/object");
  for (const View& v : capture.views) {
    fs::copy_file(masks() / "masks/transparent" / (v.stem() + ".png"), masks() / "masks/object" / (v.stem() + ".png"));
    const Image8 object = read_grey8(masks() / "masks/object" / (v.stem() + ".png"));
    ImageF photo = read_exr_rgb(linear_image_path(capture.sfm(), v));
    for (size_t i = 0; i < object.pixel_count(); ++i)
      if (object.data()[i] == 0)
        for (size_t c = 0; c < 3; ++c) photo.data()[3 * i + c] = 1;
    write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
  }
  const auto before = [&](bool object_alone) {
    capture.write_split({0}, {1, 2, 3, 4, 5, 6, 7}, object_alone);
    test::RecordingContext context(inputs());
    return run(context).at("before").at("all").get<double>();
  };
  EXPECT_LT(before(false), 10);
  EXPECT_GT(before(true), 30);
}

TEST_F(GlassBall, TrainsOnWhereSortingHelped) {
  RefineConfig config;
  config.fine_tune.iterations = 2;
  const auto steps = [&] {
    test::RecordingContext context(inputs());
    run_refine(config, context);
    return std::ranges::count_if(context.texts, [](const std::string& text) { return text.starts_with("step "); });
  };
  EXPECT_EQ(steps(), 0) << "what is right needs no training";
  add_strays();
  EXPECT_EQ(steps(), 2);
}

TEST_F(GlassBall, KeepsWhatIsRight) {
  test::RecordingContext context(inputs());
  const Json report = run(context);
  EXPECT_EQ(report.at("state"), "kept") << report.dump(1);
  EXPECT_FALSE(fs::exists(context.output() / "refine/gaussians"));
  EXPECT_EQ(read_trained_scene(capture.optimize(), context.output()).surfels.transmittance, scene.surfels.transmittance);
  EXPECT_TRUE(context.summary_text.starts_with("kept the scene as it was")) << context.summary_text;
}

// A mesh that has shrunk into what stands inside would take that for something before the glass, one that has swollen everything
// outside for the inside.
TEST_F(GlassBall, ADamagedMeshDoesNoHarm) {
  add_strays();
  TriMesh holes = test::sphere_mesh(kGlass), shifted = test::sphere_mesh(kGlass, {0.15, 0, 0.1}), inverted = holes;
  std::erase_if(holes.faces, [&](const auto& f) { return (f[0] / 7 + f[1] / 5) % 3 != 0; });
  for (auto& f : inverted.faces) std::swap(f[0], f[1]);
  const std::map<std::string, TriMesh> damaged{{"shrunk", test::sphere_mesh(0.12)},
                                               {"swollen", test::sphere_mesh(0.6)},
                                               {"holes", holes},
                                               {"shifted", shifted},
                                               {"inverted", inverted},
                                               {"empty", TriMesh{}}};
  for (const auto& [name, mesh] : damaged) {
    write_mesh_ply(capture.mesh() / "mesh/mesh.ply", mesh);
    test::RecordingContext context(inputs());
    const Json report = run(context);
    EXPECT_GE(report.at("after").at("glass"), report.at("before").at("glass")) << name << report.dump(1);
    EXPECT_GT(report.at("segments").at("fallback").get<double>(), 0.5) << name;
    EXPECT_GT(report.at("segments").at("photos_fallback"), 0) << name;
    EXPECT_TRUE(context.warnings.contains("MESH_NOT_TRUSTED")) << name;
    // The ball inside is whole, whatever went.
    const SplatLayer& layer = read_trained_scene(capture.optimize(), context.output()).surfels.transmittance;
    size_t inside = 0;
    for (size_t i = 0; i < layer.size(); ++i) {
      const float* p = layer.at(Attribute::Mean, i);
      inside += length(Vec3f{p[0], p[1], p[2]}) < 0.3f;
    }
    EXPECT_EQ(inside, 1800u) << name;
  }
}

// The ball inside is too dark: that takes training, not sorting.
TEST_F(GlassBall, FineTuningBringsTheColoursCloserAndContinuesWhereItStopped) {
  for (float& v : scene.surfels.transmittance.values(Attribute::ShDc)) v -= 0.3f;
  write_scene();
  constexpr int kSteps = 28;
  test::RecordingContext context(inputs());
  const Json report = run(context, kSteps);
  EXPECT_EQ(report.at("chosen"), "fine_tuned") << report.dump(1);
  EXPECT_GT(report.at("after").at("glass").get<double>(), report.at("before").at("glass").get<double>() + 0.3) << report.dump(1);
  EXPECT_GT(report.at("moved_voxels").at("p95").get<double>(), 0);
  EXPECT_LT(report.at("moved_voxels").at("p95").get<double>(), 0.1);
  EXPECT_FALSE(context.warnings.contains("MESH_OUTDATED"));
  const auto bytes = [](const test::RecordingContext& c) {
    return read_file(c.output() / "refine/gaussians/diffuse.ply") + read_file(c.output() / "refine/gaussians/transmittance.ply") +
           read_file(c.output() / "refine/report.json");
  };

  // Killed at step 20: the checkpoint is older than that, and leads to the same bytes. A damaged one is not used.
  struct Killed {};
  struct KilledContext : test::RecordingContext {
    using RecordingContext::RecordingContext;
    void progress(const Progress& p) override {
      if (p.text.starts_with("step 20/")) throw Killed{};
    }
  } killed(inputs());
  EXPECT_THROW(run(killed, kSteps), Killed);
  const std::string checkpoint = read_file(killed.scratch() / "checkpoint.bin");
  test::RecordingContext continued(inputs()), damaged(inputs());
  write_file(continued.scratch() / "checkpoint.bin", checkpoint);
  run(continued, kSteps);
  EXPECT_EQ(bytes(continued), bytes(context));
  EXPECT_FALSE(continued.warnings.contains("CHECKPOINT_IGNORED")) << continued.warnings["CHECKPOINT_IGNORED"];
  EXPECT_LT(continued.fractions.size(), context.fractions.size());
  write_file(damaged.scratch() / "checkpoint.bin", checkpoint.substr(0, checkpoint.size() - 1));
  run(damaged, kSteps);
  EXPECT_TRUE(damaged.warnings.contains("CHECKPOINT_IGNORED"));
  EXPECT_EQ(bytes(damaged), bytes(context));
}

// Trained with rays that see the transmittance layer alone, the scene has no wall behind the glass there; sorted into sets, the
// wall that other photos see directly stands behind the glass as well.
TEST_F(GlassBall, TheRoomBehindTracedGlassIsTheDiffuseLayers) {
  SplatLayer& diffuse = scene.surfels.diffuse;
  const SplatLayer wall = test::sphere_layer(2.5, 900);  // around everything
  const size_t first = diffuse.size();
  diffuse.resize(first + wall.size());
  for (size_t i = 0; i < wall.size(); ++i) {
    for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
      std::copy_n(wall.at(a, i), wall.width(a), diffuse.at(a, first + i));
    *diffuse.at(Attribute::Transmission, first + i) = *diffuse.at(Attribute::SpecularWeight, first + i) = -6;
  }
  take_photos();
  scene.image.transmission.glass = Glass::Traced;
  write_scene();
  test::RecordingContext context(inputs());
  const Json report = run(context);
  EXPECT_EQ(report.at("chosen"), "exterior_diffuse") << report.dump(1);
  EXPECT_GT(report.at("after").at("glass").get<double>(), report.at("before").at("glass").get<double>() + 6) << report.dump(1);
  const TrainedScene refined = read_trained_scene(capture.optimize(), context.output());
  EXPECT_EQ(refined.image.transmission.glass, Glass::Thin);
  EXPECT_EQ(refined.surfels.transmittance, scene.surfels.transmittance);
}

TEST(GlassMotion, LooksAtGlassAlone) {
  SplatLayer before(LayerKind::Diffuse, 0, 200);
  for (size_t i = 0; i < 100; ++i) *before.at(Attribute::Transmission, i) = 1;
  for (size_t i = 100; i < 200; ++i) *before.at(Attribute::Transmission, i) = -1;
  SplatLayer after = before;
  for (size_t i = 0; i < 200; ++i) after.at(Attribute::Mean, i)[i % 3] = i < 100 ? 0.01f * float(i) : 50;
  const GlassMotion motion = glass_motion(before, after);
  EXPECT_NEAR(motion.median, 0.5, 1e-6);
  EXPECT_NEAR(motion.p95, 0.95, 1e-6);
}

// With rates that carry the glass away from its mesh.
TEST_F(GlassBall, AMeshThatGlassHasLeftIsToldSo) {
  test::RecordingContext context(inputs());
  RefineConfig config;
  config.fine_tune.iterations = 4;
  config.fine_tune.unchanged = true;
  config.fine_tune.glass_factor = 1;
  config.fine_tune.rate_factor = 10;
  config.fine_tune.rates.rate[static_cast<size_t>(Attribute::Mean)] = 0.1f;
  config.fine_tune.rates.mean_end_factor = 1;
  run_refine(config, context);
  EXPECT_TRUE(context.warnings.contains("MESH_OUTDATED")) << read_file(context.output() / "refine/report.json");
}

TEST_F(GlassBall, WithoutATransmittanceLayerThereIsNothingToDo) {
  fs::remove(capture.optimize() / "gaussians/transmittance.ply");
  test::RecordingContext context(inputs());
  EXPECT_EQ(run(context).at("state"), "nothing");
  EXPECT_EQ(context.summary_text, "nothing to refine: no transmittance layer");
}

TEST_F(GlassBall, ARuinedReportOfTheMeshIsToldSo) {
  for (const char* text : {"{", R"({"voxel": 0})", R"({"voxel": "thick"})", "[]"}) {
    write_file(capture.mesh() / "mesh/grid.json", text);
    test::RecordingContext context(inputs());
    EXPECT_EQ(error_of([&] { run(context); }).detail().code, "BAD_JSON") << text;
  }
}

TEST_F(GlassBall, AListWithoutATrainingViewIsToldSo) {
  Json split{{"train", Json::array()}, {"heldout", {capture.views[0].name}}, {"holdout_every", 1}, {"max_side", 0}};
  write_file(capture.optimize() / "optimize/views.json", split.dump());
  test::RecordingContext context(inputs());
  EXPECT_EQ(error_of([&] { run(context, 3); }).detail().code, "NO_TRAINING_VIEW");
}

}  // namespace
}  // namespace vitrine
