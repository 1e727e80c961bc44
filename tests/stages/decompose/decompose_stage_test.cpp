#include "stages/decompose/decompose.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/scene/camera/scene_info.h"

#include "core/scene/camera/view_masks.h"
#include "core/scene/image/ldr.h"
#include "core/scene/light/environment.h"
#include "core/render/picture/decomposed_materials.h"
#include "core/render/picture/surfel_colors.h"
#include "stages/decompose/grey_card.h"
#include "tests/stages/decompose/shared_room.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

using test::room, test::quick;

// rms of log(scale ours / truth) after one factor per channel, their mean ratio.
double log_error(const std::vector<Vec3f>& ours, const std::vector<Vec3f>& truth) {
  double squares = 0;
  for (size_t c = 0; c < 3; ++c) {
    double mean = 0;
    for (size_t i = 0; i < ours.size(); ++i) mean += std::log(double(ours[i][c]) / double(truth[i][c])) / double(ours.size());
    for (size_t i = 0; i < ours.size(); ++i) {
      const double d = std::log(double(ours[i][c]) / double(truth[i][c])) - mean;
      squares += d * d;
    }
  }
  return std::sqrt(squares / (3 * double(ours.size())));
}

TEST(Decompose, FindsAlbedoAndLightOfAKnownScene) {
  test::RecordingContext context(room().inputs());
  run_decompose(quick(), context);
  const DecomposedMaterials materials = read_decomposed_materials(context.output());
  ASSERT_EQ(materials.size(), room().albedo.size());
  const double before = log_error(room().radiance, room().albedo), after = log_error(materials.albedo, room().albedo);
  RecordProperty("log_error", fmt::format("{} -> {}", before, after));
  EXPECT_LT(after, 0.17) << "undecomposed " << before;
  EXPECT_LT(after, 0.4 * before);
  for (const Vec3f& rho : materials.albedo)
    for (size_t c = 0; c < 3; ++c) ASSERT_TRUE(rho[c] >= 0 && rho[c] <= 1);
  EXPECT_NEAR(materials.f0[0].x, 0.04f, 1e-4f);
  EXPECT_EQ(materials.specular_weight[0], 0.f);  // there is no reflection layer that could have trained it
  // The light comes from where it does.
  const Environment light = read_environment(decomposed_environment_path(context.output()));
  const auto mean_around = [&](const Vec3f& axis) {
    float sum = 0;
    int count = 0;
    for (int k = 0; k < 400; ++k) {
      const float z = float(k % 20) / 20, a = float(k / 20) * 0.314159f, s = std::sqrt(1 - z * z);
      const Vec3f d{s * std::cos(a), s * std::sin(a), z};
      if (dot(d, axis) > 0.85f) sum += light.radiance(d).y, ++count;
    }
    return sum / float(count);
  };
  const Vec3f lamp = normalized(Vec3f{0.7f, 0.3f, 0.65f});
  EXPECT_GT(mean_around(lamp), 4 * mean_around(normalized(Vec3f{-0.7f, -0.3f, 0.65f})));
  for (const char* file : {"albedo.png", "baked.png", "report.json"})
    EXPECT_TRUE(fs::exists(context.output() / "decompose" / file));
  EXPECT_TRUE(std::ranges::is_sorted(context.fractions));
  EXPECT_GT(context.metrics.at("light_known_share"), 0.01);
}

TEST(Decompose, SameBytesForAnyNumberOfThreads) {
  std::vector<std::string> bytes;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    test::RecordingContext context(room().inputs());
    DecomposeConfig config = quick();
    config.solver_rounds = 2;
    run_decompose(config, context);
    std::string all;
    for (const char* file : {"materials.ply", "environment.exr", "report.json", "albedo.png", "baked.png"})
      all += read_file(context.output() / "decompose" / file);
    bytes.push_back(std::move(all));
  }
  set_thread_limit(0);
  EXPECT_TRUE(bytes[0] == bytes[1]);
}

TEST(Decompose, RefusesScenesWithoutSurface) {
  const auto refused = [](const std::function<void(const fs::path&)>& damage) {
    const TemporaryFolder copy;
    fs::copy(room().folder(), copy.path(), fs::copy_options::recursive);
    damage(copy.path());
    test::RecordingContext context({{"sfm", copy.path()}, {"optimize", copy.path()}, {"mesh", copy.path()}});
    const Error e = error_of([&] { run_decompose(quick(), context); });
    EXPECT_EQ(e.kind(), ErrorKind::Input) << e.what();
    return e.detail().code;
  };
  EXPECT_EQ(refused([](const fs::path& f) { write_mesh_ply(f / "mesh/mesh.ply", TriMesh{}); }), "NO_SURFACE");
  EXPECT_EQ(refused([](const fs::path& f) {
              TriMesh flat;
              flat.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0.2f, 0, 0}};
              flat.colors.resize(3);
              flat.faces = {{0, 1, 2}};
              write_mesh_ply(f / "mesh/mesh.ply", flat);
            }),
            "NO_SURFACE");
  EXPECT_EQ(refused([](const fs::path& f) { write_layer(f / "gaussians/diffuse.ply", SplatLayer(LayerKind::Diffuse, 0, 0)); }),
            "NO_SURFACE");
}

TEST(Decompose, OverexposedPhotosEndInAGuessAndAWarning) {
  const TemporaryFolder copy;
  fs::copy(room().folder(), copy.path(), fs::copy_options::recursive);
  SplatLayer layer = read_layer(copy.path() / "gaussians/diffuse.ply");
  std::ranges::fill(layer.values(Attribute::ShDc), 20.f);
  write_layer(copy.path() / "gaussians/diffuse.ply", layer);
  test::RecordingContext context({{"sfm", copy.path()}, {"optimize", copy.path()}, {"mesh", copy.path()}});
  run_decompose(quick(), context);
  EXPECT_TRUE(context.warnings.contains("FEW_DULL_POINTS"));
  for (const Vec3f& rho : read_decomposed_materials(context.output()).albedo)
    for (size_t c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(rho[c]));
}

TEST(Decompose, PixelsOfMirrorsDoNotSpeakAboutTheLight) {
  const TemporaryFolder copy, masks, objects;
  fs::copy(room().folder(), copy.path(), fs::copy_options::recursive);
  // Trained at half size; masks are as large as the photos.
  auto split = nlohmann::json::parse(read_file(copy.path() / "optimize/views.json"));
  split["max_side"] = 56;
  write_file(copy.path() / "optimize/views.json", split.dump());
  std::map<std::string, fs::path> inputs{
      {"sfm", copy.path()}, {"optimize", copy.path()}, {"mesh", copy.path()}, {"objects", objects.path()}};
  DecomposeConfig config = quick();
  config.solver_rounds = 1;
  config.sheet_rows = 0;
  for (const View& v : room().views) {
    const fs::path path = view_mask_path(masks.path(), MaskClass::Specular, v);
    make_folders(path.parent_path());
    write_ldr(path, Image8(v.intrinsics.width, v.intrinsics.height, 1, uint8_t(255)));
  }
  test::write_objects_artifact(objects.path(), masks.path(), room().views);
  test::RecordingContext context(inputs);
  run_decompose(config, context);
  EXPECT_TRUE(context.warnings.contains("FEW_DULL_POINTS"));
  write_ldr(label_path(objects.path(), room().views[0]), Image8(8, 6, 3));
  test::RecordingContext damaged(inputs);
  EXPECT_EQ(error_of([&] { run_decompose(config, damaged); }).detail().code, "BAD_LABELS");
}

// What is only guessed takes no pixel from the light and no paint from a surfel: the same bytes as without objects.
TEST(Decompose, AGuessedObjectChangesNothing) {
  const TemporaryFolder masks, objects;
  for (const View& v : room().views) {
    const fs::path path = view_mask_path(masks.path(), MaskClass::Specular, v);
    make_folders(path.parent_path());
    write_ldr(path, Image8(v.intrinsics.width, v.intrinsics.height, 1, uint8_t(255)));
  }
  DecomposeConfig config = quick();
  config.solver_rounds = 1;
  config.sheet_rows = 0;
  const auto digest = [&](std::optional<ObjectTrust> trust) {
    std::map<std::string, fs::path> inputs = room().inputs();
    if (trust) {
      const ObjectSet set{.objects = {{.id = 1, .name = "ball", .role = ObjectRole::Mirror, .trust = *trust}}, .shapes = {}};
      inputs["objects"] = test::write_objects_artifact(objects.path(), masks.path(), room().views, set);
    }
    test::RecordingContext context(inputs);
    run_decompose(config, context);
    return digest_folder(context.output());
  };
  const auto none = digest({});
  EXPECT_EQ(digest(ObjectTrust::Guessed), none);
  EXPECT_NE(digest(ObjectTrust::Given), none);
}

TEST(Decompose, WithoutPicturesTheirErrorIsAbsentNotZero) {
  test::RecordingContext context(room().inputs());
  DecomposeConfig config = quick();
  config.solver_rounds = 1;
  config.sheet_rows = 0;
  run_decompose(config, context);
  const auto report = nlohmann::json::parse(read_file(context.output() / "decompose" / "report.json"));
  EXPECT_FALSE(report.contains("baked_log_rms")) << report;
  EXPECT_FALSE(context.metrics.contains("baked_log_rms"));
}

// What the dearest settings that pass the check would hold in memory at once.
TEST(DecomposeOptions, EvenTheDearestFitAnOrdinaryMachine) {
  DecomposeConfig config;
  const OptionTable table = options_of(config);
  const auto most = [&](const char* option) { return table.find(option)->high.value(); };
  const double cells = 2 * config.bands * config.bands;
  const double both_sides = 2;
  EXPECT_LT(both_sides * most("points") * cells * sizeof(float), 2e9);          // transport
  EXPECT_LT(most("panorama_height") * most("panorama_height") * 2 * 100, 1e9);  // rays and their values
}

}  // namespace
}  // namespace vitrine
