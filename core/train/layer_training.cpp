#include "core/train/layer_training.h"

namespace vitrine {

LayerTraining::LayerTraining(const SplatLayer& layer) : adam_(layer) { accumulator_.reset(layer.size()); }

void LayerTraining::grow(size_t size) {
  adam_.resize(size);
  accumulator_.reset(size);
}

void LayerTraining::restart(const SplatLayer& layer) {
  adam_ = Adam(layer);
  accumulator_.reset(layer.size());
}

DescentCounts LayerTraining::descend(const SplatLayer& grad, const AttributeRates& rates, const SurfelStatistics& statistics,
                                     std::span<const float> damping, float rarest, SplatLayer& layer) {
  const size_t n = layer.size();
  DescentCounts done;
  active_.resize(n);
  for (size_t i = 0; i < n; ++i) done.active += active_[i] = statistics.weight[i] > 0;
  accumulator_.add(statistics);
  rarity_.clear();
  if (rarest > 1) accumulator_.rarity(rarest, rarity_);
  done.skipped = adam_.step(grad, rates, active_, layer, {.all = rarity_, .shape = damping});
  counts_.skipped_gradients += done.skipped;
  return done;
}

void LayerTraining::move(const DensifyConfig& config, const Move& move, SplatLayer& layer) {
  if (move.now) {
    const DensifyCounts done = densify(config, move.moment, {layer, adam_, accumulator_});
    counts_.relocated += done.relocated;
    counts_.added += done.added;
    counts_.removed += done.removed;
  }
  if (config.strategy == "mcmc" || config.strategy == "divide")
    add_position_noise(layer, move.noise, move.moment.seed, move.moment.step);
}

void LayerTraining::save(ArchiveWriter& out) const {
  out.value(counts_);
  adam_.save(out);
  accumulator_.save(out);
}

void LayerTraining::load(ArchiveReader& in) {
  in.value(counts_);
  adam_.load(in);
  accumulator_.load(in);
  if (accumulator_.seen.size() != adam_.size())
    throw Error(ErrorKind::Input, "a checkpoint is damaged",
                {.why = "its parts have different sizes", .hint = "the stage begins anew without it", .code = "BAD_CHECKPOINT"});
}

}  // namespace vitrine
