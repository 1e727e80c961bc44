#include "stages/optimize/trainer.h"

#include <cmath>
#include <numeric>

#include "core/base/parallel.h"
#include "core/base/rng.h"
#include "core/model/display_pass.h"

namespace vitrine {

namespace {

enum : uint64_t { kOrderStream = 0x7401 };

constexpr double kSceneRadius = 1;   // the sfm stage scales the ring of cameras to it
constexpr double kNoiseScale = 5e5;  // MCMC: noise per unit of the position's rate
constexpr double kRecentLossDecay = 0.02;
// Broken gradients: single ones happen at grazing surfels. A hundredth of all, or pictures without any surfel, ten steps in
// a row, is a failing run.
constexpr double kBadShare = 0.01;
constexpr uint32_t kBadStreak = 10;

Backend backend_of(const OptimizeConfig& config) { return config.backend == "reference" ? Backend::Reference : Backend::Cpu; }

}  // namespace

Trainer::Trainer(const OptimizeConfig& config, const Capture& capture, size_t max_surfels, SplatLayer initial)
    : config_(config),
      capture_(capture),
      max_surfels_(max_surfels),
      scene_{std::move(initial)},
      grad_{scene_.diffuse.zeros_like()},
      adam_(scene_.diffuse) {
  auto diffuse = std::make_unique<DiffusePass>(DiffuseOptions{.backend = backend_of(config), .sh_degree = config.sh_degree});
  diffuse_pass_ = diffuse.get();
  model_.add(std::move(diffuse));
  model_.add(std::make_unique<DisplayPass>());
  accumulator_.reset(scene_.diffuse.size());
}

size_t Trainer::level() const {
  return fraction() < config_.resolution.quarter_until ? 2 : fraction() < config_.resolution.half_until ? 1 : 0;
}

uint32_t Trainer::photo_of_step() {
  const uint64_t count = capture_.train.size(), epoch = step_ / count;
  if (epoch != order_epoch_) {  // a permutation that depends on the epoch's number alone
    order_ = capture_.train;
    Rng rng(static_cast<uint64_t>(config_.seed), mix64(kOrderStream, epoch));
    for (size_t i = order_.size() - 1; i > 0; --i) std::swap(order_[i], order_[rng.below(static_cast<uint32_t>(i + 1))]);
    order_epoch_ = epoch;
  }
  return order_[step_ % count];
}

void Trainer::step() {
  const size_t l = level();
  const PhotoLevel& photo = capture_.photos[photo_of_step()].levels[l];
  const double loss = descend(photo);
  if (!std::isfinite(loss))
    throw Error(ErrorKind::Diverged, "training broke down: the loss is not a number",
                {.where = fmt::format("step {}, photo {}", step_, photo.view.name),
                 .hint = "lower the rates (--set optimize.rates.mean=8e-5) or change the seed",
                 .code = "LOSS_NOT_FINITE"});
  ++step_;
  move_surfels();
}

double Trainer::descend(const PhotoLevel& photo) {
  const double f = fraction();
  diffuse_pass_->set_sh_degree(f < config_.sh_from ? 0 : config_.sh_degree);
  bool distortion = false;
  for (const LossTerm& term : config_.loss.terms()) distortion |= term.factory->name == "distortion" && term.schedule.at(f) > 0;
  diffuse_pass_->set_distortion(distortion);
  decode(photo, target_);
  model_.forward(scene_, photo.view, frame_);

  // What the surfels can be blamed for: the difference in the displayed picture, a mean over the channels.
  const size_t pixels = frame_.pixel_count();
  frame_.error_image.resize(pixels);
  constexpr size_t kChunk = 1 << 14;
  std::vector<double> error_sums(chunk_count(pixels, kChunk));
  parallel_chunks(pixels, kChunk, [&](size_t chunk, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      frame_.error_image[i] = (std::abs(frame_.srgb[i] - target_[i]) + std::abs(frame_.srgb[pixels + i] - target_[pixels + i]) +
                               std::abs(frame_.srgb[2 * pixels + i] - target_[2 * pixels + i])) /
                              3.f;
    for (size_t i = begin; i < end; ++i) error_sums[chunk] += frame_.error_image[i];
  });

  grad_.diffuse.fill(0.f);
  const LossInput input{.view = &photo.view,
                        .raster = &frame_.diffuse,
                        .prediction_srgb = frame_.srgb,
                        .target_srgb = target_,
                        .weight = {},
                        .diffuse = &scene_.diffuse};
  LossGradient gradient{.raster = &frame_.grad_diffuse, .prediction_srgb = frame_.grad_srgb, .diffuse = &grad_.diffuse};
  const LossValues values = config_.loss.evaluate(f, input, gradient);
  model_.backward(scene_, frame_, grad_);

  const size_t n = scene_.diffuse.size();
  active_.resize(n);
  size_t active = 0;
  for (size_t i = 0; i < n; ++i) active += active_[i] = frame_.statistics.weight[i] > 0;
  const AttributeRates rates = rates_at(config_.rates, f, kSceneRadius);
  const size_t skipped = adam_.step(grad_.diffuse, rates, active_, scene_.diffuse);
  counts_.skipped_gradients += skipped;
  bad_streak_ = active == 0 || double(skipped) > kBadShare * double(active) ? bad_streak_ + 1 : 0;
  if (bad_streak_ >= kBadStreak)
    throw Error(
        ErrorKind::Diverged, "training broke down: the surfels are gone or their gradients are not numbers",
        {.where = fmt::format("step {}, photo {}", step_, photo.view.name),
         .why = fmt::format("{} of {} gradients of visible surfels are broken, {} steps in a row", skipped, active, bad_streak_),
         .hint = "lower the rates (--set optimize.rates.mean=8e-5) or change the seed",
         .code = "GRADIENTS_NOT_FINITE"});
  accumulator_.add(frame_.statistics);

  record(values.total, std::accumulate(error_sums.begin(), error_sums.end(), 0.0) / double(pixels));
  return values.total;
}

void Trainer::move_surfels() {
  const DensifyConfig& d = config_.densify;
  const double f = fraction();
  if (d.strategy == "none" || f < d.from || f > d.until) return;
  const auto seed = static_cast<uint64_t>(config_.seed);
  if (step_ % static_cast<uint64_t>(d.every) == 0) {
    const DensifyCounts done = densify(d, {.seed = seed, .step = step_, .cap = max_surfels_, .scene_radius = kSceneRadius},
                                       {scene_.diffuse, adam_, accumulator_});
    counts_.relocated += done.relocated;
    counts_.added += done.added;
    counts_.removed += done.removed;
    grad_.diffuse.resize(scene_.diffuse.size());
  }
  if (d.strategy == "mcmc" || d.strategy == "divide") {
    const float rate = rates_at(config_.rates, f, kSceneRadius)[static_cast<size_t>(Attribute::Mean)];
    add_position_noise(scene_.diffuse, static_cast<float>(d.noise * kNoiseScale * rate), seed, step_);
  }
}

void Trainer::record(double loss, double l1) {
  recent_loss_ = step_ == 0 ? loss : recent_loss_ + kRecentLossDecay * (loss - recent_loss_);
  const double count = double(capture_.train.size());
  epoch_.loss += loss / count;
  epoch_.l1 += l1 / count;
  if ((step_ + 1) % capture_.train.size() != 0) return;
  epoch_.step = step_ + 1;
  epoch_.surfels = scene_.diffuse.size();
  epochs_.push_back(epoch_);
  epoch_ = {};
}

void Trainer::picture(uint32_t photo, Frame& frame) const {
  diffuse_pass_->set_sh_degree(fraction() < config_.sh_from ? 0 : config_.sh_degree);
  diffuse_pass_->set_distortion(false);
  model_.forward(scene_, capture_.photos[photo].levels[0].view, frame);
}

void Trainer::save(ArchiveWriter& out) const {
  out.value(step_);
  out.value(bad_streak_);
  out.value(recent_loss_);
  out.value(epoch_);
  out.array(std::span<const EpochRecord>(epochs_));
  out.value(counts_);
  out.layer(scene_.diffuse);
  adam_.save(out);
  accumulator_.save(out);
}

void Trainer::load(ArchiveReader& in) {
  in.value(step_);
  in.value(bad_streak_);
  in.value(recent_loss_);
  in.value(epoch_);
  in.array(epochs_);
  in.value(counts_);
  in.layer(scene_.diffuse);
  adam_.load(in);
  accumulator_.load(in);
  if (adam_.size() != scene_.diffuse.size() || accumulator_.seen.size() != scene_.diffuse.size() || !in.at_end())
    throw Error(ErrorKind::Input, "a checkpoint is damaged", {.why = "its parts have different sizes", .code = "BAD_CHECKPOINT"});
  grad_.diffuse = scene_.diffuse.zeros_like();
}

}  // namespace vitrine
