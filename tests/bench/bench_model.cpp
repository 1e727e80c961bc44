// The image model forward and backward with all three layers: 480x270, 50k + 15k + 15k surfels, a fifth of the picture reflects
// and transmits. Beside it the same scene with the diffuse layer alone, which must cost what it always did, and the passes one by
// one.
//   budget: pixels that send rays (0: all). Losses, decoding and Adam are not in these rows.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/render/model/composite_pass.h"
#include "core/render/model/layered_model.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {
namespace {

// Surfels on a sphere, facing its centre; `cover`: their summed areas at one deviation, in areas of the sphere.
void add_shell(SplatLayer& layer, size_t count, const Vec3d& centre, double radius, double opacity, double cover, uint64_t seed) {
  Rng rng(seed);
  const double size = std::sqrt(cover * 4 * 3.14159 * radius * radius / double(count) / (2 * 3.14159));
  const size_t first = layer.size();
  layer.resize(first + count);
  for (size_t i = first; i < layer.size(); ++i) {
    const Vec3d n = normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()}), mean = centre + radius * n;
    const Vec3d helper = std::abs(n.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{1, 0, 0}, u = normalized(cross(helper, n));
    const Quatd q = quaternion(Mat3d{u, cross(n, u), n});
    const double rotation[] = {q.w, q.x, q.y, q.z};
    for (size_t c = 0; c < 4; ++c) layer.at(Attribute::Rotation, i)[c] = float(rotation[c]);
    for (size_t c = 0; c < 3; ++c) {
      layer.at(Attribute::Mean, i)[c] = float(mean[c]);
      layer.at(Attribute::ShDc, i)[c] = rng.uniform() - 1.2f;
    }
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = float(std::log(size)) + 0.3f * rng.normal();
    *layer.at(Attribute::Opacity, i) = float(logit(opacity)) + 0.7f * rng.normal();
    const bool shiny = layer.kind() == LayerKind::Diffuse && length(mean) < 0.5;
    if (layer.kind() != LayerKind::Diffuse) continue;
    for (Attribute a : {Attribute::F0, Attribute::Roughness}) layer.at(a, i)[0] = -2;
    for (Attribute a : {Attribute::SpecularWeight, Attribute::Transmission}) *layer.at(a, i) = shiny ? 0.f : -9.f;
  }
}

struct Room {
  SplatScene scene;
  View view;
};

// A ball of glass in a room; reflections of the room stand in a shell of several sheets around, what is inside the glass within.
Room glass_ball() {
  Room r;
  r.scene.diffuse = SplatLayer(LayerKind::Diffuse, 1, 0);
  r.scene.reflection = SplatLayer(LayerKind::Reflection, 1, 0);
  r.scene.transmittance = SplatLayer(LayerKind::Transmittance, 1, 0);
  add_shell(r.scene.diffuse, 35000, {0, 0, 0}, 1.6, 0.8, 5, 1);
  add_shell(r.scene.diffuse, 15000, {0, 0, 0}, 0.3, 0.8, 5, 2);
  for (uint64_t i = 0; i < 5; ++i) {
    add_shell(r.scene.reflection, 3000, {0, 0, 0}, 1 + 0.3 * double(i), 0.5, 3, 3 + i);
    add_shell(r.scene.transmittance, 3000, {0, 0, 0}, 0.05 + 0.05 * double(i), 0.5, 3, 13 + i);
  }
  r.view.intrinsics = {480, 270, 350, 350, 240, 135};
  r.view.cam_from_world.translation = {0, 0, 1.1};
  return r;
}

void model_step(benchmark::State& state, int budget, Lobe lobe, bool layers) {
  Room r = glass_ball();
  if (!layers) r.scene.reflection = r.scene.transmittance = SplatLayer();
  ImageOptions options;
  options.surface.ray_budget = budget;
  options.reflection.lobe = lobe;
  LayeredModel model(options);
  Frame frame;
  SplatScene grad = r.scene.zeros_like();
  const auto step = [&] {
    ++frame.step;
    model.forward(r.scene, r.view, frame);
    for (size_t i = 0; i < frame.srgb.size(); ++i) frame.grad_srgb[i] = frame.srgb[i] > 0.4f ? 1e-6f : -1e-6f;
    for (LayerKind kind : kAllLayers) grad.layer(kind).fill(0.f);
    model.backward(r.scene, frame, grad);
  };
  step();
  const double share = double(frame.shaded.pixels.size()) / double(frame.pixel_count());
  if (layers && !(share > 0.15 && share < 0.25)) return state.SkipWithError("the ball does not cover a fifth of the picture");
  for (auto _ : state) step();
  state.counters["specular"] = share;
  state.counters["rays"] = double(frame.reflection.rays.size() + frame.transmission.rays.size());
  if (layers)
    state.counters["hits_per_ray"] =
        double(frame.reflection.hits.size() + frame.transmission.hits.size()) / state.counters["rays"].value;
}

// CPU time of each pass, as counters in ms.
void model_passes(benchmark::State& state, int budget) {
  const Room r = glass_ball();
  ImageOptions options;
  options.surface.ray_budget = budget;
  LayeredModel model(options);
  Frame frame;
  frame.view = &r.view;
  frame.options = options;
  SplatScene grad = r.scene.zeros_like();
  const auto passes = model.passes();
  std::vector<double> ms(2 * passes.size());
  const auto timed = [&](double& sum, const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    sum += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  };
  double steps = 0;
  for (auto _ : state) {
    for (size_t i = 0; i < passes.size(); ++i) timed(ms[i], [&] { passes[i]->forward(r.scene, frame); });
    for (size_t i = 0; i < frame.srgb.size(); ++i) frame.grad_srgb[i] = frame.srgb[i] > 0.4f ? 1e-6f : -1e-6f;
    start_statistics(r.scene, frame);
    for (size_t i = passes.size(); i-- > 0;) timed(ms[passes.size() + i], [&] { passes[i]->backward(r.scene, frame, grad); });
    ++steps;
  }
  for (size_t i = 0; i < passes.size(); ++i) {
    state.counters[std::string(passes[i]->name()) + ">"] = ms[i] / steps;
    state.counters[std::string(passes[i]->name()) + "<"] = ms[passes.size() + i] / steps;
  }
}

const auto apply = [](auto* row) { row->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime()->UseRealTime(); };
const int kRows = [] {
  apply(benchmark::RegisterBenchmark("model/diffuse_alone", [](auto& s) { model_step(s, 0, Lobe::Mirror, false); }));
  apply(benchmark::RegisterBenchmark("model/three_sets/budget:0", [](auto& s) { model_step(s, 0, Lobe::Mirror, true); }));
  apply(benchmark::RegisterBenchmark("model/three_sets/budget:10000", [](auto& s) { model_step(s, 10000, Lobe::Mirror, true); }));
  apply(benchmark::RegisterBenchmark("model/three_sets/budget:10000/sampled",
                                     [](auto& s) { model_step(s, 10000, Lobe::Sampled, true); }));
  apply(benchmark::RegisterBenchmark("model/passes/budget:10000", [](auto& s) { model_passes(s, 10000); }));
  return 0;
}();

}  // namespace
}  // namespace vitrine
