// Sparse Adam (Kingma and Ba 2015) for a layer of surfels, one step size per attribute: only surfels visible in the picture are
// updated, and each counts its own steps for the bias correction (adam_update.h). A surfel with a non-finite gradient is skipped
// and counted.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/learn/optim/adam_update.h"
#include "core/learn/optim/archive.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Factors on a surfel's step sizes, [n] or empty. (Applied to the step, since Adam cancels the scale of the gradient.)
struct StepFactors {
  std::span<const float> all = {};    // of every attribute
  std::span<const float> shape = {};  // of geometry and opacity, in addition
  std::span<const float> place = {};  // of positions, in addition
};

using AttributeRates = std::array<float, kAttributeCount>;  // 0 = the attribute is not trained

class Adam {
 public:
  explicit Adam(const SplatLayer& shape, const AdamDesc& desc = {});

  // Updates the surfels with active[i] != 0. Returns the number skipped because of a non-finite gradient.
  size_t step(const SplatLayer& grad, const AttributeRates& rates, std::span<const uint8_t> active, SplatLayer& layer,
              const StepFactors& factors = {});

  size_t size() const { return steps_.size(); }
  void resize(size_t size);                        // new surfels start without history
  void forget(size_t surfel);                      // resets the history of one surfel
  void keep_only(std::span<const uint32_t> kept);  // ascending indices of the remaining surfels

  // The whole state, for a training on a device.
  struct Moments {
    SplatLayer &m, &v;
    std::vector<uint32_t>& steps;
  };
  Moments moments() { return {m_, v_, steps_}; }
  void transfer(Archive& archive);

 private:
  AdamDesc desc_;
  SplatLayer m_, v_;
  std::vector<uint32_t> steps_;
  AdamCorrections corrections_;
};

// Moves the surfels at `kept` (ascending) to the front and drops the rest.
void keep_surfels(SplatLayer& layer, std::span<const uint32_t> kept);

}  // namespace vitrine
