// Adam (Kingma and Ba 2015) over a layer of surfels, one step size per attribute, sparse: only surfels that took part in the
// picture move, and each counts its own steps for the bias correction:
//   m <- b1 m + (1-b1) g    v <- b2 v + (1-b2) g^2    x <- x - rate * m/(1-b1^t) / (sqrt(v/(1-b2^t)) + eps)
// A surfel with a gradient that is not finite is left alone and counted.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/learn/optim/archive.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

struct AdamDesc {
  double beta1 = 0.9, beta2 = 0.999;
  float epsilon = 1e-15f;  // tiny: gradients of means over an image are tiny themselves
};

// Factors on a surfel's step sizes, [n] or empty. (On the step and not on the gradient, whose scale Adam takes out again.)
struct StepFactors {
  std::span<const float> all = {};    // of every attribute
  std::span<const float> shape = {};  // of geometry and opacity, on top
  std::span<const float> place = {};  // of positions, on top
};

using AttributeRates = std::array<float, kAttributeCount>;  // 0 = the attribute is not trained

class Adam {
 public:
  explicit Adam(const SplatLayer& shape, const AdamDesc& desc = {});

  // Moves the surfels with active[i] != 0. Returns how many were left alone because of a gradient that is not finite.
  size_t step(const SplatLayer& grad, const AttributeRates& rates, std::span<const uint8_t> active, SplatLayer& layer,
              const StepFactors& factors = {});

  size_t size() const { return steps_.size(); }
  void resize(size_t size);                        // new surfels start without history
  void forget(size_t surfel);                      // history of one surfel back to zero
  void keep_only(std::span<const uint32_t> kept);  // ascending indices of the surfels that stay

  void transfer(Archive& archive);

 private:
  AdamDesc desc_;
  SplatLayer m_, v_;
  std::vector<uint32_t> steps_;
  std::vector<float> correction1_, correction2_;  // 1/(1-b1^t) and 1/sqrt(1-b2^t) by t, until they are 1
};

// Moves the surfels at `kept` (ascending) to the front and drops the rest.
void keep_surfels(SplatLayer& layer, std::span<const uint32_t> kept);

}  // namespace vitrine
