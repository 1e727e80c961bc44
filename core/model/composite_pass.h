// Puts the layers together in linear light (kernels/layer_blend.h):  linear = w_d C_d + w_r C_r + w_t C_t  in shaded pixels; the
// others keep the diffuse radiance. The reverse turns frame.grad_linear into the gradient of the diffuse radiance and leaves
// those of the other radiances and of the materials with the groups of pixels.
#pragma once

#include "core/model/image_options.h"
#include "core/model/pass.h"

namespace vitrine {

class GBuffer;

class CompositePass final : public Pass {
 public:
  explicit CompositePass(const CompositeOptions& options) : options_(options) {}
  std::string_view name() const override { return "composite"; }
  CompositeOptions& options() { return options_; }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  float gate(const Frame& frame, uint32_t pixel) const;
  void behind_backward(Frame& frame, const GBuffer& buffer, size_t group) const;

  CompositeOptions options_;
  std::vector<float> reflected_;  // [h,w] sqrt of the mean of w_r C_r, for the gate
};

}  // namespace vitrine
