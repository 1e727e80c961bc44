// What stands in a known case of glass: the light on it under a known sky, and its albedo under a solved one.
#include "stages/decompose/transport.h"

#include <gtest/gtest.h>

#include "core/render/picture/decomposed_materials.h"
#include "stages/decompose/decompose.h"
#include "tests/stages/decompose/shared_room.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

struct Case {
  test::LitRoom room{true};
  TrainedScene scene = read_trained_scene(room.folder(), std::nullopt);
  TriMesh mesh = read_shadow_mesh(room.folder()), content = read_mesh_ply(room.folder() / "mesh/behind_glass.ply");
  Surroundings around{.centre = {},
                      .height = 4,
                      .distance = std::vector<float>(32, 0.f),
                      .radiance = std::vector<Vec3f>(32),
                      .wall = std::vector<bool>(32, false)};
  TriMesh shell;
  LitPointsDesc points{.inner = {{-0.6, -0.6, -0.1}, {0.6, 0.6, 0.4}}, .voxel = 0.03, .max_side = 112};
  TransportDesc rays{.grid = {.bands = 12}, .reach = 0.12f, .offset = 0.004f};
  SpreadDesc spread{.inner_radius = 0.03f};

  std::vector<Vec3f> sky() const {
    std::vector<Vec3f> light(rays.grid.cells());
    for (size_t j = 0; j < light.size(); ++j)
      for (const float u : {0.25f, 0.75f})
        for (const float v : {0.25f, 0.75f}) light[j] += 0.25f * test::LitRoom::sky(rays.grid.direction(j, u, v));
    return light;
  }
  std::vector<Vec3f> irradiance(const std::vector<float>& transmission, const TriMesh& shadows) const {
    return irradiance_behind_glass({.scene = scene,
                                    .views = room.views,
                                    .first = {.mesh = mesh, .transmission = transmission, .around = around, .shell = shell},
                                    .content = shadows,
                                    .light = sky(),
                                    .points = points,
                                    .rays = rays,
                                    .spread = spread},
                                   [](double) {});
  }
  // log(irradiance / truth) over the surfels behind glass: mean, and rms about it.
  std::pair<double, double> error(const std::vector<Vec3f>& irradiance) const {
    double sum = 0, squares = 0, n = 0;
    size_t k = 0;
    for (size_t i = 0; i < room.albedo.size(); ++i) {
      if (!room.behind_glass(i)) continue;
      const double truth = std::numbers::pi * double(room.radiance[i].y) / double(room.albedo[i].y);
      const double d = std::log(double(irradiance[k++].y) / truth);
      sum += d, squares += d * d, n += 1;
    }
    return {sum / n, std::sqrt(squares / n - sum * sum / (n * n))};
  }
  std::vector<float> clear_panes() const {
    return transmission_of(mesh, lit_points(scene.surfels.diffuse, room.views, points, [](double) {}), points.voxel);
  }
};

TEST(BehindGlass, LightPassesThePanesAndThingsThrowShadows) {
  const Case c;
  const auto [mean, spread] = c.error(c.irradiance(c.clear_panes(), c.content));
  RecordProperty("log_error", fmt::format("mean {}, spread {}", mean, spread));
  EXPECT_LT(std::abs(mean), 0.06);
  EXPECT_LT(spread, 0.16);
  // Without the box in the case, or with panes that nothing passes, it is another light.
  const auto [no_shadows, no_shadows_spread] = c.error(c.irradiance(c.clear_panes(), {}));
  EXPECT_GT(no_shadows_spread, 1.1 * spread);
  EXPECT_LT(c.error(c.irradiance({}, c.content)).first, mean - 0.1);
}

TEST(BehindGlass, WithoutAnySuchSurfelThereIsNone) {
  Case c;
  c.scene.surfels.transmittance.resize(0);
  EXPECT_TRUE(c.irradiance(c.clear_panes(), c.content).empty());
}

// rms of log(ours / truth) about its mean per channel.
double spread_of(const std::vector<Vec3f>& ours, const std::vector<Vec3f>& truth) {
  double squares = 0;
  for (size_t c = 0; c < 3; ++c) {
    double sum = 0, sum2 = 0;
    const double n = double(ours.size());
    for (size_t i = 0; i < ours.size(); ++i) {
      const double d = std::log(double(ours[i][c]) / double(truth[i][c]));
      sum += d, sum2 += d * d;
    }
    squares += sum2 / n - sum * sum / (n * n);
  }
  return std::sqrt(squares / 3);
}

// What is seen through the panes of a known case has its albedo in the scale of what photos show directly; light that reaches it
// has passed the panes, and what stands in the case throws shadows there.
TEST(Decompose, FindsAlbedoBehindGlass) {
  const test::LitRoom cased(true);
  test::RecordingContext context(cased.inputs());
  run_decompose(test::quick(), context);
  const DecomposedMaterials materials = read_decomposed_materials(context.output());
  std::vector<Vec3f> direct, behind, true_direct, true_behind, radiance;
  for (size_t i = 0; i < cased.albedo.size(); ++i) {
    const bool inside = cased.behind_glass(i);
    (inside ? true_behind : true_direct).push_back(cased.albedo[i]);
    if (inside)
      radiance.push_back(cased.radiance[i]);
    else
      direct.push_back(materials.albedo[direct.size()]);
  }
  behind = materials.albedo_behind_glass;
  ASSERT_EQ(behind.size(), true_behind.size());
  // One factor per channel, of what is seen directly.
  Vec3f scale;
  for (size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (size_t i = 0; i < direct.size(); ++i) sum += std::log(double(true_direct[i][c]) / double(direct[i][c]));
    scale[c] = float(std::exp(sum / double(direct.size())));
  }
  double squares = 0, mean = 0;
  for (size_t i = 0; i < behind.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const double d = std::log(double(scale[c] * behind[i][c]) / double(true_behind[i][c]));
      squares += d * d, mean += d;
    }
  const double n = 3 * double(behind.size()), error = std::sqrt(squares / n), before = spread_of(radiance, true_behind);
  RecordProperty("log_error", fmt::format("{} -> {} (mean {})", before, error, mean / n));
  EXPECT_LT(error, 0.6 * before);
  EXPECT_LT(std::abs(mean / n), 0.1);
}

}  // namespace
}  // namespace vitrine
