#include "core/learn/optim/densify.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/rigid.h"
#include "core/learn/optim/densify_rules.h"
#include "core/learn/optim/rates.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr double kGradientThreshold = 2e-4;  // minimum mean screen-space gradient for densification (classic)
constexpr double kFaintOpacity = 0.05;       // fainter surfels are removed (classic)
constexpr double kSplitShrink = 1.6;         // children of a split are smaller by this (Kerbl et al. 2023)

float opacity_of(const SplatLayer& layer, size_t i) { return sigmoid(*layer.at(Attribute::Opacity, i)); }

Mat3f axes_of(const SplatLayer& layer, size_t i) {
  const float* q = layer.at(Attribute::Rotation, i);
  return rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]}));
}

// Moves a surfel by normal deviates along its own two axes.
void jitter_in_plane(SplatLayer& layer, size_t i, Rng& rng) {
  const Mat3f axes = axes_of(layer, i);
  const float* log_scale = layer.at(Attribute::LogScale, i);
  const float u = std::exp(log_scale[0]) * rng.normal(), v = std::exp(log_scale[1]) * rng.normal();
  for (size_t c = 0; c < 3; ++c) layer.at(Attribute::Mean, i)[c] += u * axes.c0[c] + v * axes.c1[c];
}

// Parent and copy become the two halves of the parent along its longer axis, with its opacity: unlike coincident copies they do
// not occlude each other, so detail grows without overdraw.
void divide(SplatLayer& layer, size_t parent, size_t copy) {
  float* log_scale = layer.at(Attribute::LogScale, parent);
  const size_t longer = log_scale[1] > log_scale[0];
  const Mat3f axes = axes_of(layer, parent);
  const float offset = kHalfOffset * std::exp(log_scale[longer]);
  log_scale[longer] += std::log(kHalfLong);
  log_scale[1 - longer] += std::log(kHalfShort);
  layer.copy_surfel(parent, copy);
  for (size_t c = 0; c < 3; ++c) {
    layer.at(Attribute::Mean, parent)[c] -= offset * axes.column(longer)[c];
    layer.at(Attribute::Mean, copy)[c] += offset * axes.column(longer)[c];
  }
}

// Sums of division_chance.
std::vector<double> cumulative_chances(const SplatLayer& layer, const SurfelAccumulator& accumulator,
                                       const std::vector<uint8_t>& dead) {
  const size_t n = layer.size();
  double error_sum = 0;
  for (float e : accumulator.error) error_sum += e;
  const double mean_error = error_sum / double(std::max<size_t>(n, 1));
  std::vector<double> cumulative(n);
  double sum = 0;
  for (size_t i = 0; i < n; ++i) {
    if (!dead[i]) sum += division_chance<double>(opacity_of(layer, i), accumulator.error[i], mean_error);
    cumulative[i] = sum;
  }
  return cumulative;
}

size_t drawn(const std::vector<double>& cumulative, Rng& rng) {
  const double x = rng.uniform_double() * cumulative.back();
  const auto it = std::upper_bound(cumulative.begin(), cumulative.end(), x);
  return std::min<size_t>(static_cast<size_t>(it - cumulative.begin()), cumulative.size() - 1);
}

// Assigns every slot of `slots` to a randomly chosen living surfel, which is divided.
void copy_onto(const DensifyMoment& moment, DensifyTarget& target, const std::vector<uint32_t>& slots,
               const std::vector<double>& cumulative, uint64_t stream) {
  std::vector<uint32_t> parents(slots.size());
  Rng draw(moment.seed, mix64(stream, moment.step));
  for (uint32_t& parent : parents) parent = static_cast<uint32_t>(drawn(cumulative, draw));
  for (size_t k = 0; k < slots.size(); ++k) {
    divide(target.layer, parents[k], slots[k]);
    target.accumulator.share[slots[k]] = target.accumulator.share[parents[k]];
    target.adam.forget(parents[k]);
    target.adam.forget(slots[k]);
  }
}

DensifyCounts relocate_and_grow(const DensifyConfig& config, const DensifyMoment& moment, DensifyTarget& target) {
  SplatLayer& layer = target.layer;
  const size_t n = layer.size();
  // Surfels that contribute to hardly any pixel, mostly occluded ones, are relocated.
  double weight_sum = 0;
  for (float w : target.accumulator.weight) weight_sum += w;
  const double least_weight = config.idle_weight * weight_sum / double(std::max<size_t>(n, 1));
  std::vector<uint8_t> dead(n);
  std::vector<uint32_t> slots;
  for (size_t i = 0; i < n; ++i)
    if ((dead[i] = opacity_of(layer, i) <= kDeadOpacity || target.accumulator.weight[i] < least_weight))
      slots.push_back(static_cast<uint32_t>(i));
  const std::vector<double> cumulative = cumulative_chances(layer, target.accumulator, dead);
  DensifyCounts counts;
  if (n == 0 || cumulative.back() <= 0) return counts;
  copy_onto(moment, target, slots, cumulative, kRelocateStream);
  counts.relocated = slots.size();

  const double growth = std::pow(config.growth, moment.times);
  const auto grown = static_cast<size_t>(std::min(double(moment.cap), std::ceil(double(n) * growth)));
  if (grown > n) {
    layer.resize(grown);
    target.adam.resize(grown);
    target.accumulator.share.resize(grown);
    slots.resize(grown - n);
    std::iota(slots.begin(), slots.end(), static_cast<uint32_t>(n));
    copy_onto(moment, target, slots, cumulative, kGrowStream);
    counts.added = grown - n;
  }
  return counts;
}

DensifyCounts clone_split_prune(const DensifyConfig& config, const DensifyMoment& moment, DensifyTarget& target) {
  SplatLayer& layer = target.layer;
  const size_t n = layer.size();
  const double largest_clone = config.split_size_rel * moment.scene_radius;
  std::vector<uint32_t> wanted;
  for (size_t i = 0; i < n; ++i) {
    const double seen = target.accumulator.seen[i];
    if (seen > 0 && target.accumulator.screen_gradient[i] / seen > kGradientThreshold) wanted.push_back(static_cast<uint32_t>(i));
  }
  if (const size_t room = moment.cap > n ? moment.cap - n : 0; wanted.size() > room) {  // at the cap, highest gradients first
    std::stable_sort(wanted.begin(), wanted.end(), [&](uint32_t a, uint32_t b) {
      const auto& s = target.accumulator;
      return s.screen_gradient[a] * float(s.seen[b]) > s.screen_gradient[b] * float(s.seen[a]);
    });
    wanted.resize(room);
  }
  DensifyCounts counts;
  counts.added = wanted.size();
  layer.resize(n + wanted.size());
  target.adam.resize(layer.size());
  target.accumulator.share.resize(layer.size());
  for (size_t k = 0; k < wanted.size(); ++k) {
    const size_t parent = wanted[k], child = n + k;
    layer.copy_surfel(parent, child);
    target.accumulator.share[child] = target.accumulator.share[parent];
    float* log_scale = layer.at(Attribute::LogScale, parent);
    if (std::exp(std::max(log_scale[0], log_scale[1])) <= largest_clone) continue;  // a clone starts as an identical surfel
    for (size_t half : {parent, child}) {
      Rng rng(moment.seed, mix64(kSplitStream, mix64(moment.step, half)));
      jitter_in_plane(layer, half, rng);
      for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, half)[c] -= static_cast<float>(std::log(kSplitShrink));
    }
    target.adam.forget(parent);
  }
  std::vector<uint32_t> kept;
  for (size_t i = 0; i < layer.size(); ++i)
    if (opacity_of(layer, i) >= kFaintOpacity) kept.push_back(static_cast<uint32_t>(i));
  counts.removed = layer.size() - kept.size();
  keep_surfels(layer, kept);
  target.adam.keep_only(kept);
  target.accumulator.keep_only(kept);
  return counts;
}

float mean_share(const std::vector<float>& share) {
  double sum = 0;
  for (float s : share) sum += double(s);
  return share.empty() ? 1.f : float(sum / double(share.size()));
}

}  // namespace

void SurfelAccumulator::reset(size_t size) {
  weight.assign(size, 0.f);
  error.assign(size, 0.f);
  screen_gradient.assign(size, 0.f);
  seen.assign(size, 0);
  pictures = 0;
  share.resize(size, mean_share(share));
}

void SurfelAccumulator::keep_only(std::span<const uint32_t> kept) {
  for (size_t to = 0; to < kept.size(); ++to) share[to] = share[kept[to]];
  share.resize(kept.size());
}

void SurfelAccumulator::rarity(float most, std::vector<float>& factor) const {
  const float mean = mean_share(share);
  factor.resize(share.size());
  for (size_t i = 0; i < share.size(); ++i) factor[i] = rarity_factor(mean, share[i], most);
}

void SurfelAccumulator::add(const SurfelStatistics& statistics) {
  ++pictures;
  for (size_t i = 0; i < seen.size(); ++i) {
    const bool takes_part = statistics.weight[i] > 0;
    share[i] += kShareDecay * (float(takes_part) - share[i]);
    if (!takes_part) continue;
    weight[i] += statistics.weight[i];
    if (!statistics.error.empty()) error[i] += statistics.error[i];
    screen_gradient[i] += statistics.screen_gradient[i];
    ++seen[i];
  }
}

void SurfelAccumulator::transfer(Archive& archive) {
  for (auto* values : {&weight, &error, &screen_gradient, &share}) archive.array(*values);
  archive.array(seen);
  archive.value(pictures);
  for (const size_t size : {share.size(), error.size(), screen_gradient.size(), seen.size()})
    if (size != weight.size()) archive.fail("statistics of different sizes");
}

DensifyRhythm densify_rhythm(const DensifyConfig& config, size_t photos, double window) {
  const uint64_t pass = std::max<size_t>(photos, 1), every = static_cast<uint64_t>(config.every);
  const uint64_t whole = (every + pass - 1) / pass * pass;
  if (double(whole) > window) return {.interval = every};
  return {.interval = whole, .times = static_cast<int>(whole / every), .pictures = pass};
}

DensifyCounts densify(const DensifyConfig& config, const DensifyMoment& moment, DensifyTarget target) {
  DensifyCounts counts;
  if (config.strategy == DensifyStrategy::Divide) counts = relocate_and_grow(config, moment, target);
  if (config.strategy == DensifyStrategy::Classic) counts = clone_split_prune(config, moment, target);
  target.accumulator.reset(target.layer.size());
  return counts;
}

void add_position_noise(SplatLayer& layer, float strength, uint64_t seed, uint64_t step) {
  if (strength <= 0) return;
  constexpr size_t kChunk = 1024;
  parallel_chunks(layer.size(), kChunk, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float gate = noise_gate(opacity_of(layer, i));
      if (gate < NoiseRule::kLeastGate) continue;
      Rng rng(seed, mix64(kNoiseStream, mix64(step, i)));
      const Vec3f xi{rng.normal(), rng.normal(), rng.normal()};
      const Mat3f axes = axes_of(layer, i);
      const float* log_scale = layer.at(Attribute::LogScale, i);
      const float u = std::exp(2 * log_scale[0]) * dot(axes.c0, xi), v = std::exp(2 * log_scale[1]) * dot(axes.c1, xi);
      float* mean = layer.at(Attribute::Mean, i);
      const float walk = gate * strength / far_factor(mean);  // u and v grow with the square of the distance
      for (size_t c = 0; c < 3; ++c) mean[c] += walk * (u * axes.c0[c] + v * axes.c1[c]);
    }
  });
}

}  // namespace vitrine
