// Depth maps of the user: their scale, their place in the undistorted photos, what they do for the normals.
#include "stages/normals/given_depth.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/observe/stereo/known_depth.h"
#include "core/scene/camera/undistort.h"
#include "stages/normals/normals.h"
#include "tests/stages/normals/still_life.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using test::RecordingContext;
using test::StillLife;

const StillLife& depth_scene() {
  static const StillLife life;
  return life;
}

double true_depth(const StillLife& life, size_t view, double x, double y) {
  const StillLife::Point p = life.at(view, x, y);
  return p.surface == StillLife::Nothing ? 0 : (life.views[view].cam_from_world * p.position).z;
}

// One PNG for each view, `value` of the depth in the unit of the scene; 0 stays 0.
fs::path write_depth(const StillLife& life, const fs::path& folder, const std::function<double(size_t, double)>& value) {
  make_folders(folder);
  for (size_t v = 0; v < life.views.size(); ++v) {
    Image16 image(StillLife::kWidth, StillLife::kHeight, 1);
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        if (const double z = true_depth(life, v, x + 0.5, y + 0.5); z > 0)
          image.at(x, y) = uint16_t(std::lround(1000 * value(v, z)));
    write_png16(folder / (life.views[v].stem() + ".png"), image);
  }
  return folder;
}

struct DepthRun {
  explicit DepthRun(const std::map<std::string, fs::path>& inputs) : context(inputs) {
    Stage stage = normals_stage();
    for (const auto& [path, text] : {std::pair{"source", "geometric"}, {"geometric.max_side", "96"}})
      stage.options.find(path)->assign(text, "test");
    stage.run(context);
    report = nlohmann::json::parse(read_file(context.output() / "normals/report.json"));
  }
  RecordingContext context;
  nlohmann::json report;
};

std::unique_ptr<DepthRun> run_with(const StillLife& life, const fs::path& depth) {
  std::map<std::string, fs::path> inputs{{"sfm", life.sfm()}};
  if (!depth.empty()) inputs["depth"] = depth;
  return std::make_unique<DepthRun>(inputs);
}

// Median error of the normals of the painted ball, in degrees, and the share that is known.
std::pair<double, double> ball_normals(const StillLife& life, const fs::path& artifact) {
  std::vector<double> errors;
  size_t pixels = 0;
  for (size_t v = 0; v < life.views.size(); ++v) {
    const ImageF map = read_exr(artifact / "normals" / (life.views[v].stem() + ".exr")).pixels;
    for (int y = 0; y < map.height(); ++y)
      for (int x = 0; x < map.width(); ++x) {
        const double px = (x + 0.5) * StillLife::kWidth / map.width(), py = (y + 0.5) * StillLife::kHeight / map.height();
        if (life.at(v, px, py).surface != StillLife::Ball) continue;
        ++pixels;
        const float* p = map.pixel(x, y);
        if (const Vec3f n{p[0], p[1], p[2]}; length(n) > 0.5f) errors.push_back(test::degrees(n, life.normal(v, px, py)));
      }
  }
  const double known = double(errors.size()) / double(pixels);
  std::nth_element(errors.begin(), errors.begin() + std::ptrdiff_t(errors.size() / 2), errors.end());
  return {errors[errors.size() / 2], known};
}

// Whatever unit they are in, the points give their scale.
TEST(GivenDepth, IsWrittenInTheUnitOfTheSceneAndImprovesTheNormals) {
  const TemporaryFolder folder;
  const StillLife& life = depth_scene();
  const auto with = run_with(life, write_depth(life, folder.path() / "d", [](size_t, double z) { return 3.7 * z; }));
  EXPECT_TRUE(with->context.warnings.empty());
  EXPECT_TRUE(with->report["depth"]["used"].get<bool>());
  EXPECT_EQ(with->report["depth"]["photos"], life.views.size());
  EXPECT_NEAR(with->report["depth"]["units_per_metre"].get<double>(), 1 / 3.7, 0.005 / 3.7);
  EXPECT_LT(with->report["depth"]["spread"].get<double>(), 0.02);
  size_t known = 0, wrong = 0;
  for (size_t v = 0; v < life.views.size(); ++v) {
    const ExrImage map = read_exr(known_depth_path(with->context.output(), life.views[v]));
    EXPECT_EQ(map.channels, (std::vector<std::string>{"Z"}));
    ASSERT_EQ(map.pixels.width(), StillLife::kWidth);
    for (int y = 0; y < map.pixels.height(); ++y)
      for (int x = 0; x < map.pixels.width(); ++x) {
        const double truth = true_depth(life, v, x + 0.5, y + 0.5), z = double(map.pixels.at(x, y));
        EXPECT_EQ(z > 0, truth > 0);
        known += truth > 0, wrong += truth > 0 && std::abs(z / truth - 1) > 0.005;
      }
  }
  EXPECT_GT(known, 10000u);
  EXPECT_EQ(wrong, 0u);
  const auto without = run_with(life, {});
  EXPECT_FALSE(fs::exists(without->context.output() / "depth"));
  const auto [before, known_before] = ball_normals(life, without->context.output());
  const auto [after, known_after] = ball_normals(life, with->context.output());
  EXPECT_LT(after, 0.7 * before) << before << " " << after;
  EXPECT_GE(known_after, known_before);
  RecordProperty("ball_median_deg", fmt::format("{:.2f} without, {:.2f} with", before, after));
}

TEST(GivenDepth, InverseDepthIsNotUsedAndChangesNothing) {
  const TemporaryFolder folder;
  const StillLife& life = depth_scene();
  const auto inverse_depth =
      run_with(life, write_depth(life, folder.path() / "i", [](size_t, double z) { return 0.1 + 1 / (z * z * z); }));
  EXPECT_TRUE(inverse_depth->context.warnings.count("DEPTH_DISAGREES") == 1);
  EXPECT_FALSE(inverse_depth->report["depth"]["used"].get<bool>());
  EXPECT_FALSE(fs::exists(inverse_depth->context.output() / "depth"));
}

TEST(GivenDepth, AMapOfAnotherScaleIsLeftOut) {
  const TemporaryFolder folder;
  const StillLife& life = depth_scene();
  write_depth(life, folder.path(), [](size_t view, double z) { return view == 3 ? 1.4 * z : z; });
  fs::remove(folder.path() / (life.views[5].stem() + ".png"));
  Notes notes;
  const auto given = given_depth(folder.path(), life.sfm(), load_view_set(life.sfm()), 96, notes);
  ASSERT_TRUE(given);
  EXPECT_EQ(given->other_scale, 1u);
  EXPECT_TRUE(given->maps[3].empty());
  EXPECT_TRUE(given->maps[5].empty());
  EXPECT_EQ(given->photos, life.views.size() - 2);
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_EQ(notes[0].code, "DEPTH_INCOMPLETE");
  EXPECT_EQ(notes[1].code, "DEPTH_PHOTOS_LEFT_OUT");
}

TEST(GivenDepth, ItsScaleNeedsPointsThatAgree) {
  std::vector<DepthRatio> ratios;
  for (uint32_t i = 0; i < kFewestRatios - 1; ++i) ratios.push_back({i % 3, 2.0 + i, 1 + 0.5 * i});
  EXPECT_FALSE(depth_scale(ratios, 3));
  for (uint32_t i = 0; i < 12; ++i) ratios.push_back({i % 2, i % 2 == 0 ? 2.02 : 9, 1});
  const auto scale = depth_scale(ratios, 3);
  ASSERT_TRUE(scale);
  EXPECT_EQ(scale->scale, 2);  // a fifth of the points lies elsewhere
  EXPECT_EQ(scale->other_scale, (std::vector<uint8_t>{0, 0, 0}));
  EXPECT_TRUE(scale->plausible());
  // Noise of 12 % is less than half of what the depths themselves vary by; inverse depths vary by more, however little that is.
  for (const double range : {1.5, 0.02}) {
    std::vector<DepthRatio> noisy, inverse;
    for (uint32_t i = 0; i < 60; ++i) {
      const double z = std::exp(range * (double(i) / 60 - 0.5)), noise = i % 2 == 0 ? 1.12 : 1 / 1.12;
      noisy.push_back({0, z, z * noise});
      inverse.push_back({0, z, 1 / z});
    }
    EXPECT_EQ(depth_scale(noisy, 1)->plausible(), range > 1) << range;
    EXPECT_FALSE(depth_scale(inverse, 1)->plausible() && range > 1) << range;
  }
}

// A map at the photo as it was taken, three times smaller, of a lens with distortion: a slanted wall.
TEST(GivenDepth, IsUndistortedLikeTheMasks) {
  const StillLife life(6);
  const ColmapCamera lens{
      .id = 1, .model_id = colmap_camera_type("SIMPLE_RADIAL")->id, .width = 120, .height = 90, .params = {110, 60, 45, -0.15}};
  const Undistortion u = undistortion(lens);
  ASSERT_FALSE(u.identity);
  ColmapModel model = read_colmap_model(life.sfm() / "sparse/0");
  model.cameras[0] = colmap_pinhole(1, u.target);
  for (ColmapImage& image : model.images) image.points.clear();
  model.points.clear();
  write_colmap_model(life.sfm() / "sparse/0", model, ColmapFormat::Binary);
  SceneInfo metric;
  metric.scale_known = true;
  metric.scene_from_colmap.scale = 0.5;
  write_scene_info(life.sfm() / "scene.json", metric);
  write_file(
      life.sfm() / "sfm/lenses.json",
      R"({"cameras": [{"id": 1, "photographed": {"id": 1, "model": "SIMPLE_RADIAL", "width": 120, "height": 90, "params": [110, 60, 45, -0.15]}}]})");
  const auto wall = [](double x, double y) { return 1 / (0.4 + 0.3 * x + 0.2 * y); };  // of the direction (x, y, 1)
  const TemporaryFolder folder;
  for (const View& view : life.views) {
    ImageF map(360, 270, 1);
    for (int y = 0; y < map.height(); ++y)
      for (int x = 0; x < map.width(); ++x) {
        const Vec2d d = unproject(lens, {(x + 0.5) / 3, (y + 0.5) / 3}).value();
        map.at(x, y) = float(wall(d.x, d.y));
      }
    write_exr(folder.path() / (view.stem() + ".exr"), {.pixels = map, .channels = {"Z"}, .attributes = {}}, ExrPrecision::Float);
  }
  Notes notes;
  const auto given = given_depth(folder.path(), life.sfm(), load_view_set(life.sfm()), 1000, notes);
  ASSERT_TRUE(given);
  EXPECT_TRUE(given->from_frame);  // no point: the unit of the poses
  EXPECT_EQ(given->units_per_metre, 0.5);
  const ImageF& map = given->maps[0];
  ASSERT_EQ(map.width(), u.target.width);
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      const Vec3d ray = u.target.ray(x + 0.5, y + 0.5);
      const double z = wall(ray.x, ray.y), half_a_pixel = z * z * (0.3 + 0.2) * 1.3 / (6 * 110);  // of the map
      EXPECT_NEAR(map.at(x, y), 0.5 * z, 0.5 * half_a_pixel) << x << " " << y;
    }
  ImageF turned(270, 360, 1, 1.f);
  turned.at(3, 3) = 2;
  write_exr(folder.path() / (life.views[0].stem() + ".exr"), {.pixels = turned, .channels = {"Z"}, .attributes = {}});
  const Error e = error_of([&] { given_depth(folder.path(), life.sfm(), load_view_set(life.sfm()), 1000, notes); });
  EXPECT_EQ(e.detail().code, "DEPTH_SIZE");
}

}  // namespace
}  // namespace vitrine
