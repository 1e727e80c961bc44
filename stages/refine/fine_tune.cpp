#include "stages/refine/fine_tune.h"

#include <algorithm>
#include <utility>

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr size_t kGrain = 1 << 14;  // floats
constexpr uint64_t kSeed = 1;
constexpr double kAverageFrom = 0.25;  // fraction of the steps after which scenes enter the mean

// All masked pixels except coats send rays; losses and rates are those at the end of training.
StepPlan plan_of(const FineTuneConfig& config, const TrainedScene& start) {
  StepPlan plan{.image = start.image,
                .rarest = float(config.rates.rarest),
                .coats_send_rays = false,
                .glass_factor = static_cast<float>(config.glass_factor),
                .one_glass = start.surfels.transmittance.size() > 0 && start.surfels.reflection.size() > 0};
  plan.image.surface.ray_budget = config.ray_budget;
  AttributeRates rates = rates_at(config.rates, plan.fraction, kSceneRadius);
  for (float& rate : rates) rate *= static_cast<float>(config.rate_factor);
  plan.rates.fill(rates);
  return plan;
}

}  // namespace

void describe(Describer& d, FineTuneConfig& c) {
  d.option("iterations", c.iterations, "Training steps after surfels were removed; 0 = none.").range(0, 10000000);
  d.option("ray_budget", c.ray_budget, "Pixels of a picture that send rays in a step; 0 = all that reflect or transmit.")
      .range(0, 100000000);
  d.option("checkpoint_every", c.checkpoint_every, "Steps between two checkpoints; 0 = only on interruption.")
      .range(0, 10000000)
      .affects_output(false);
}

GlassMotion glass_motion(const SplatLayer& before, const SplatLayer& after) {
  std::vector<double> way;
  for (size_t i = 0; i < before.size(); ++i) {
    if (!(*before.at(Attribute::Transmission, i) > 0)) continue;  // raw value: tau > 1/2
    const float *a = before.at(Attribute::Mean, i), *b = after.at(Attribute::Mean, i);
    way.push_back(length(Vec3d{double(b[0]) - double(a[0]), double(b[1]) - double(a[1]), double(b[2]) - double(a[2])}));
  }
  if (way.empty()) return {};
  std::ranges::sort(way);
  return {.median = way[way.size() / 2], .p95 = way[way.size() * 95 / 100]};
}

FineTune::FineTune(const FineTuneConfig& config, const Capture& capture, const Targets& targets, const TrainedScene& start)
    : Training({.capture = capture,
                .targets = targets,
                .losses = config.loss,
                .steps = static_cast<uint64_t>(config.iterations),
                .seed = kSeed,
                .remedy = "--set refine.fine_tune.iterations=0"},
               plan_of(config, start).image, start.surfels),
      plan_(plan_of(config, start)),
      average_after_(kAverageFrom * config.iterations),
      mean_(scene().zeros_like()) {}

void FineTune::end_step() {
  if (double(step_index()) <= average_after_) return;
  const float part = 1.f / static_cast<float>(++averaged_);
  for (LayerKind kind : kAllLayers)
    for (const AttributeRow& r : kAttributes) {
      const std::span<const float> now = scene().layer(kind).values(r.id);
      const std::span<float> mean = mean_.layer(kind).values(r.id);
      parallel_chunks(mean.size(), kGrain, [&](size_t, size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) mean[i] += part * (now[i] - mean[i]);
      });
    }
}

void FineTune::transfer(Archive& archive) {
  Training::transfer(archive);
  archive.value(averaged_);
  for (LayerKind kind : kAllLayers) {
    SplatLayer& mean = mean_.layer(kind);
    const size_t surfels = mean.size();
    archive.layer(mean);
    if (mean.kind() != kind || mean.size() != surfels || scene().layer(kind).size() != surfels)
      archive.fail("its parts have different sizes");
  }
}

}  // namespace vitrine
