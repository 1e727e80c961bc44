#include "core/learn/trainer/layer_training.h"

#include <algorithm>

#include "core/foundation/math/spherical_harmonics.h"
#include "core/learn/optim/densify_rules.h"
#include "core/learn/optim/rates.h"

namespace vitrine {

namespace {

// A negative channel renders black and has no gradient (shade.h clamps it), so it would stay black forever: the constant SH
// term is clamped above zero.
void keep_above_black(std::span<const uint8_t> active, SplatLayer& layer) {
  const float least = (kLeastColour - 0.5f) / kShDc;
  for (size_t i = 0; i < layer.size(); ++i)
    for (size_t c = 0; active[i] && c < 3; ++c)
      layer.at(Attribute::ShDc, i)[c] = std::max(layer.at(Attribute::ShDc, i)[c], least);
}

// Step scale of positions by distance; empty if all surfels are near.
void far_factors(const SplatLayer& layer, std::vector<float>& factors) {
  factors.clear();
  for (size_t i = 0; i < layer.size(); ++i) {
    const float factor = far_factor(layer.at(Attribute::Mean, i));
    if (factor == 1) continue;
    if (factors.empty()) factors.assign(layer.size(), 1.f);
    factors[i] = factor;
  }
}

}  // namespace

LayerTraining::LayerTraining(const SplatLayer& layer) : adam_(layer) { accumulator_.reset(layer.size()); }

void LayerTraining::grow(size_t size) {
  adam_.resize(size);
  accumulator_.reset(size);
}

void LayerTraining::keep_only(std::span<const uint32_t> kept) {
  adam_.keep_only(kept);
  accumulator_.keep_only(kept);
  accumulator_.reset(kept.size());
}

void LayerTraining::restart(const SplatLayer& layer) {
  adam_ = Adam(layer);
  accumulator_ = {};
  accumulator_.reset(layer.size());
}

DescentCounts LayerTraining::descend(const SplatLayer& grad, const SurfelStatistics& statistics, const Descent& descent,
                                     SplatLayer& layer) {
  const size_t n = layer.size();
  DescentCounts done;
  active_.resize(n);
  for (size_t i = 0; i < n; ++i) done.active += active_[i] = i < descent.trained && statistics.weight[i] > 0;
  accumulator_.add(statistics);
  rarity_.clear();
  if (descent.rarest > 1) accumulator_.rarity(descent.rarest, rarity_);
  far_factors(layer, distance_);
  done.skipped = adam_.step(grad, descent.rates, active_, layer, {.all = rarity_, .shape = descent.damping, .place = distance_});
  keep_above_black(active_, layer);
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
  if (config.strategy == DensifyStrategy::Divide) add_position_noise(layer, move.noise, move.moment.seed, move.moment.step);
}

void LayerTraining::transfer(Archive& archive) {
  archive.value(counts_);
  adam_.transfer(archive);
  accumulator_.transfer(archive);
  if (accumulator_.seen.size() != adam_.size()) archive.fail("its parts have different sizes");
}

}  // namespace vitrine
