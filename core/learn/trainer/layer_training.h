// One layer of surfels while it is trained: Adam's moments, what pictures said about its surfels, and where they go.
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

// Of one descent: surfels that took part in the picture, and those among them whose gradient is no number.
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
    float rarest = 1;                     // most that the steps of what few pictures show grow by (SurfelAccumulator::rarity)
    size_t trained = SIZE_MAX;            // so many surfels; those behind them stay as they are
  };
  DescentCounts descend(const SplatLayer& grad, const SurfelStatistics& statistics, const Descent& descent, SplatLayer& layer);
  // Relocation and growth when `now`, and the random walk of faint surfels (strength 0: none).
  struct Move {
    DensifyMoment moment;
    bool now = false;
    float noise = 0;
  };
  void move(const DensifyConfig& config, const Move& move, SplatLayer& layer);
  // Surfels were added behind the others: they start without history.
  void grow(size_t size);
  // The surfels at `kept` (ascending) alone are left of the layer: they go on with their history.
  void keep_only(std::span<const uint32_t> kept);
  // The layer was changed from outside: statistics and moments start over.
  void restart(const SplatLayer& layer);

  const TrainCounts& counts() const { return counts_; }
  uint32_t pictures() const { return accumulator_.pictures; }  // since surfels were last moved, or the layer was changed
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
