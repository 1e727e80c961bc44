#include "stages/refine/fine_tune.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/parallel.h"
#include "core/train/photo_order.h"
#include "core/train/picture_step.h"

namespace vitrine {

namespace {

constexpr double kSceneRadius = 1;  // the sfm stage scales the ring of cameras to it
constexpr size_t kGrain = 1 << 14;  // floats

ImageOptions options_of(const TrainedScene& scene, const FineTuneConfig& config) {
  ImageOptions o = scene.image;
  o.surface.ray_budget = config.ray_budget;
  o.composite.gate = static_cast<float>(config.gate);
  return o;
}

}  // namespace

void describe(Describer& d, FineTuneConfig& c) {
  d.option("iterations", c.iterations, "Training steps after surfels were sorted; 0 = none.").range(0, 10000000);
  d.option("unchanged", c.unchanged, "Also where neither sorting nor bent rays made the glass better.");
  d.option("rate_factor", c.rate_factor, "Factor on the rates that a training ends with.").range(0, 10);
  d.option("average_from", c.average_from, "Part of the steps after which scenes count in the mean that is kept.").range(0, 1);
  d.option("glass_factor", c.glass_factor, "Factor on the rates of geometry and opacity where surfels are transparent.")
      .range(0, 1);
  d.option("gate", c.gate, "Damps gradients of what is seen through glass where reflections vary strongly; 0 = off.")
      .range(0, 1000);
  d.option("ray_budget", c.ray_budget, "Pixels of a picture that send rays in a step; 0 = all that reflect or transmit.")
      .range(0, 100000000);
  d.option("seed", c.seed, "Seed of all random numbers.").range(0, 2147483647);
  d.option("checkpoint_every", c.checkpoint_every, "Steps between two checkpoints; 0 = only on interruption.")
      .range(0, 10000000)
      .affects_output(false);
  d.group("rates", c.rates, "Step sizes of Adam.");
  d.group("loss", c.loss, "What training makes small; parts of the run are those of the steps here.");
}

GlassMotion glass_motion(const SplatLayer& before, const SplatLayer& after) {
  std::vector<double> way;
  for (size_t i = 0; i < before.size(); ++i) {
    if (!(*before.at(Attribute::Transmission, i) > 0)) continue;  // raw: tau > 1/2
    const float *a = before.at(Attribute::Mean, i), *b = after.at(Attribute::Mean, i);
    way.push_back(length(Vec3d{double(b[0]) - double(a[0]), double(b[1]) - double(a[1]), double(b[2]) - double(a[2])}));
  }
  if (way.empty()) return {};
  std::ranges::sort(way);
  return {.median = way[way.size() / 2], .p95 = way[way.size() * 95 / 100]};
}

FineTune::FineTune(const FineTuneConfig& config, const Capture& capture, const Targets& targets, const TrainedScene& start)
    : config_(config),
      capture_(capture),
      targets_(targets),
      model_(options_of(start, config)),
      scene_(start.surfels),
      grad_(scene_.zeros_like()),
      mean_(scene_.zeros_like()) {
  for (LayerKind kind : kAllLayers) training_.emplace_back(scene_.layer(kind));
}

uint32_t FineTune::photo_of_step() const {
  const uint64_t count = capture_.train.size();
  return photo_order(capture_.train, static_cast<uint64_t>(config_.seed), step_ / count)[step_ % count];
}

void FineTune::step() {
  const uint32_t index = photo_of_step();
  const PhotoLevel& photo = capture_.photos[index].levels[0];
  decode(photo, target_);
  decode(targets_.photos[index][0], images_);
  const auto ignore = images_.mask(MaskClass::Ignore);
  weight_.resize(ignore.size());
  for (size_t i = 0; i < ignore.size(); ++i) weight_[i] = 1 - ignore[i];
  frame_.seed = static_cast<uint64_t>(config_.seed);
  frame_.step = step_;
  frame_.specular_mask = images_.mask(MaskClass::Specular);
  frame_.transparent_mask = images_.mask(MaskClass::Transparent);
  model_.forward(scene_, photo.view, frame_);

  const PictureTarget target{.view = &photo.view, .srgb = target_, .weight = weight_, .targets = images_.spans()};
  const LossValues values = learn(target, config_.loss, 1, step_, model_, scene_, frame_, grad_);
  if (!std::isfinite(values.total))
    throw Error(ErrorKind::Diverged, "fine-tuning broke down: the loss is not a number",
                {.where = fmt::format("step {}, photo {}", step_, photo.view.name),
                 .hint = "--set refine.fine_tune.iterations=0",
                 .code = "LOSS_NOT_FINITE"});
  update();
  ++step_;
  average();
}

void FineTune::update() {
  hold_glass(scene_.diffuse, static_cast<float>(config_.glass_factor), damping_, {}, grad_.diffuse);
  AttributeRates rates = rates_at(config_.rates, 1, kSceneRadius);
  for (float& rate : rates) rate *= static_cast<float>(config_.rate_factor);
  for (LayerKind kind : kAllLayers) {
    const bool diffuse = kind == LayerKind::Diffuse;
    const SurfelStatistics& statistics = statistics_of(frame_, kind);
    if (!took_part(frame_, kind)) continue;
    training_[static_cast<size_t>(kind)].descend(
        grad_.layer(kind), statistics,
        {.rates = rates,
         .damping = diffuse ? std::span<const float>(damping_) : std::span<const float>(),
         .rarest = float(config_.rates.rarest)},
        scene_.layer(kind));
  }
  if (scene_.transmittance.size() > 0 && scene_.reflection.size() > 0) share_glass(scene_.diffuse);
}

void FineTune::average() {
  if (double(step_) <= config_.average_from * config_.iterations) return;
  const float part = 1.f / static_cast<float>(++averaged_);
  for (LayerKind kind : kAllLayers)
    for (const AttributeRow& r : kAttributes) {
      const std::span<const float> now = std::as_const(scene_).layer(kind).values(r.id);
      const std::span<float> mean = mean_.layer(kind).values(r.id);
      parallel_chunks(mean.size(), kGrain, [&](size_t, size_t first, size_t last) {
        for (size_t i = first; i < last; ++i) mean[i] += part * (now[i] - mean[i]);
      });
    }
}

void FineTune::save(ArchiveWriter& out) const {
  out.value(step_);
  out.value(averaged_);
  for (LayerKind kind : kAllLayers) {
    out.layer(scene_.layer(kind));
    out.layer(mean_.layer(kind));
    training_[static_cast<size_t>(kind)].save(out);
  }
}

void FineTune::load(ArchiveReader& in) {
  in.value(step_);
  in.value(averaged_);
  bool fits = true;
  for (LayerKind kind : kAllLayers) {
    SplatLayer scene, mean;
    in.layer(scene);
    in.layer(mean);
    LayerTraining& training = training_[static_cast<size_t>(kind)];
    training.load(in);
    fits &= scene.size() == scene_.layer(kind).size() && mean.size() == scene.size() && training.size() == scene.size();
    fits &= scene.kind() == kind && mean.kind() == kind;
    scene_.layer(kind) = std::move(scene);
    mean_.layer(kind) = std::move(mean);
  }
  if (!fits || !in.at_end())
    throw Error(ErrorKind::Input, "a checkpoint is damaged",
                {.why = "its parts have different sizes", .hint = "the stage begins anew without it", .code = "BAD_CHECKPOINT"});
}

}  // namespace vitrine
