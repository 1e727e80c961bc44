// One whole training step: decode the photo, rasterise, losses, reverse, Adam, statistics, and densification where it falls.
// Arguments: width, height, surfels. The scene is a cloud of surfels on the walls of a box with a ball in it, seen from inside.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/scene/surfels/activation.h"
#include "stages/optimize/trainer.h"

namespace vitrine {
namespace {

const ShapeSet kNoShapes;

SplatLayer box_with_ball(size_t surfels) {
  SplatLayer layer(LayerKind::Diffuse, 1, surfels);
  Rng rng(2);
  const double area_per_surfel = 24.0 / double(surfels);  // a box of edge two
  for (size_t i = 0; i < surfels; ++i) {
    Vec3d position{2 * rng.uniform_double() - 1, 2 * rng.uniform_double() - 1, 2 * rng.uniform_double() - 1}, normal{};
    const uint32_t side = rng.below(8);
    if (side < 6) {
      position[side / 2] = side % 2 ? 1 : -1;
      normal[side / 2] = side % 2 ? -1 : 1;
    } else {
      normal = normalized(position);
      position = 0.4 * normal;
    }
    const Vec3d helper = std::abs(normal.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}, u = normalized(cross(helper, normal));
    const Quatd q = quaternion(Mat3d{u, cross(normal, u), normal});
    const double rotation[] = {q.w, q.x, q.y, q.z};
    for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = float(rotation[c]);
    for (size_t c = 0; c < 3; ++c) {
      layer.at(Attribute::Mean, i)[c] = float(position[c]);
      layer.at(Attribute::ShDc, i)[c] = rng.uniform() - 1.2f;
    }
    for (size_t c = 0; c < 2; ++c)
      layer.at(Attribute::LogScale, i)[c] = float(std::log(0.6 * std::sqrt(area_per_surfel))) + 0.4f * rng.normal();
    *layer.at(Attribute::Opacity, i) = 1.5f + rng.normal();
  }
  return layer;
}

Capture box_capture(int width, int height) {
  Capture capture;
  constexpr int kViews = 8;
  for (int v = 0; v < kViews; ++v) {
    const double angle = 2 * 3.14159265358979 * v / kViews;
    const Vec3d eye{0.9 * std::cos(angle), 0.9 * std::sin(angle), 0.2}, forward = normalized(-eye);
    const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1})), down = cross(forward, right);
    View view;
    view.name = fmt::format("{}.png", v);
    view.intrinsics = {width, height, 0.8 * width, 0.8 * width, 0.5 * width, 0.5 * height};
    view.cam_from_world = inverse(Rigid{Mat3d{right, down, forward}, eye});
    ImageF photo(width, height, 3);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (int c = 0; c < 3; ++c)
          photo.at(x, y, c) = 0.3f + 0.25f * std::sin(0.05f * float(x + 20 * v)) * std::cos(0.07f * float(y + c));
    capture.view_set.views.push_back(view);
    capture.photos.push_back(make_photo(view, photo, 0));
    capture.train.push_back(static_cast<uint32_t>(v));
  }
  return capture;
}

// The upper half of the ball is glass, the lower one a mirror: a fifth of the picture.
Targets ball_targets(const Capture& capture) {
  Targets targets;
  targets.has[size_t(MaskClass::Transparent)] = targets.has[size_t(MaskClass::Specular)] = true;
  for (const auto& photo : capture.photos) {
    auto& levels = targets.photos.emplace_back();
    for (size_t l = 0; l < kLevels; ++l) {
      const View& view = photo.levels[l].view;
      const Intrinsics& k = view.intrinsics;
      const Vec3d eye = view.centre_in_world();
      auto& masks = levels[l].masks;
      for (MaskClass kind : {MaskClass::Transparent, MaskClass::Specular}) masks[size_t(kind)].assign(k.pixel_count(), 0);
      for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x) {
          const Vec3d d = normalized(view.ray(x + 0.5, y + 0.5));
          if (length(eye - dot(eye, d) * d) > 0.205) continue;
          const size_t i = k.index(x, y);
          masks[size_t(MaskClass::Specular)][i] = 255;
          if (2 * y < k.height) masks[size_t(MaskClass::Transparent)][i] = 255;
        }
    }
  }
  return targets;
}

// All three layers, 50k + 15k surfels and what moves behind the glass. `budget`: pixels that send reflected rays (0: all).
void layered_training_step(benchmark::State& state) {
  constexpr int kDiffuse = 50000, kAll = 80000;
  OptimizeConfig config;
  config.max_gaussians = kAll;
  config.resolution.quarter_until = config.resolution.half_until = 0;
  config.sh_from = 0;
  config.iterations = 1000000000;
  config.densify.strategy = DensifyStrategy::None;
  config.shading.ray_budget = static_cast<int>(state.range(0));
  PhasesConfig& p = config.phases;
  p.reflection.from = p.transmittance.from = p.reflection.ramp = p.transmittance.ramp = p.reflection.surface_from = 0;
  p.reflection.share = p.transmittance.share = 0.27;
  p.reflection.initial_surfels = 15000;
  const Capture capture = box_capture(480, 270);
  const Targets targets = ball_targets(capture);
  Trainer trainer({.config = config,
                   .capture = capture,
                   .targets = targets,
                   .shapes = kNoShapes,
                   .glass = kNoShapes,
                   .layers = {.reflection = true, .transmittance = true}},
                  box_with_ball(kDiffuse), {});
  trainer.step();
  if (!(trainer.recent_loss() > 0 && trainer.recent_loss() < 2))
    return state.SkipWithError("the first step gave an impossible loss");
  for (auto _ : state) trainer.step();
  double marked = 0;
  for (const auto& photo : targets.photos)
    for (uint8_t m : photo[0].masks[size_t(MaskClass::Specular)]) marked += m > 0;
  state.counters["specular"] = marked / (480 * 270 * double(targets.photos.size()));
  for (LayerKind kind : kAllLayers) state.counters[std::string(name(kind))] = double(trainer.scene().layer(kind).size());
}
BENCHMARK(layered_training_step)
    ->ArgName("budget")
    ->Arg(0)
    ->Arg(12000)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

void whole_training_step(benchmark::State& state) {
  const auto surfels = static_cast<size_t>(state.range(2));
  OptimizeConfig config;
  config.max_gaussians = static_cast<int>(surfels);
  config.resolution.quarter_until = config.resolution.half_until = 0;
  config.sh_from = 0;
  config.iterations = 1000000000;
  config.densify.from = 0;
  const Capture capture = box_capture(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  Targets targets;  // nobody says anything about any photo
  targets.photos.resize(capture.photos.size());
  Trainer trainer(
      {.config = config, .capture = capture, .targets = targets, .shapes = kNoShapes, .glass = kNoShapes, .layers = {}},
      box_with_ball(surfels), {});
  trainer.step();
  if (!(trainer.recent_loss() > 0 && trainer.recent_loss() < 1)) {
    state.SkipWithError("the first step gave an impossible loss");
    return;
  }
  for (auto _ : state) trainer.step();
  state.counters["loss"] = trainer.recent_loss();
}
BENCHMARK(whole_training_step)
    ->ArgNames({"width", "height", "surfels"})
    ->Args({480, 270, 13000})
    ->Args({480, 270, 50000})
    ->Args({1008, 752, 100000})
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace vitrine
