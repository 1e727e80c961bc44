// Training state of one layer of surfels: Adam's moments, accumulated statistics, and densification.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/learn/optim/adam.h"
#include "core/learn/optim/archive.h"
#include "core/learn/optim/densify.h"

namespace vitrine {

struct TrainCounts {
  uint64_t skipped_gradients = 0, relocated = 0, added = 0, removed = 0;
};

// Counts of one descent: surfels visible in the picture, and those among them with a non-finite gradient.
struct DescentCounts {
  size_t active = 0, skipped = 0;
};

class LayerTraining {
 public:
  explicit LayerTraining(const SplatLayer& layer);

  // One step of Adam on the surfels with weight in the picture.
  struct Descent {
    const AttributeRates& rates;
    std::span<const float> damping = {};  // StepFactors::shape
    float rarest = 1;                     // maximum visibility step scale (SurfelAccumulator::rarity)
    size_t trained = SIZE_MAX;            // number of trained surfels; the following ones remain unchanged
  };
  DescentCounts descend(const SplatLayer& grad, const SurfelStatistics& statistics, const Descent& descent, SplatLayer& layer);
  // Relocation and growth if `now`, and the random walk of faint surfels (strength 0: none).
  struct Move {
    DensifyMoment moment;
    bool now = false;
    float noise = 0;
  };
  void move(const DensifyConfig& config, const Move& move, SplatLayer& layer);
  // Call after appending surfels: they start without history.
  void grow(size_t size);
  // Call after keeping only the surfels at `kept` (ascending): they keep their history.
  void keep_only(std::span<const uint32_t> kept);
  // Call after external changes of the layer: resets statistics and moments.
  void restart(const SplatLayer& layer);

  const TrainCounts& counts() const { return counts_; }
  TrainCounts& counts() { return counts_; }
  Adam& adam() { return adam_; }
  SurfelAccumulator& accumulator() { return accumulator_; }
  uint32_t pictures() const { return accumulator_.pictures; }  // since the last densification or external change of the layer
  void transfer(Archive& archive);
  size_t size() const { return adam_.size(); }

 private:
  Adam adam_;
  SurfelAccumulator accumulator_;
  TrainCounts counts_;
  std::vector<uint8_t> active_;
  std::vector<float> rarity_, distance_;
};

}  // namespace vitrine
