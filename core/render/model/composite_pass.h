// Blends the layers in linear light (kernels/layer_blend.h):  linear = w_d C_d + w_r C_r + w_t C_t  in shaded pixels; all other
// pixels keep the diffuse radiance. The backward pass converts frame.grad_linear to the gradient of the diffuse radiance and
// stores the gradients of the other radiances and of the materials per pixel group.
#pragma once

#include "core/render/model/pass.h"

namespace vitrine {

class GBuffer;

class CompositePass final : public Pass {
 public:
  std::string_view name() const override { return "composite"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels, FramePart::Surfaces, FramePart::ReflectionRequests,
                      FramePart::TransmissionRequests, FramePart::BehindGlass, FramePart::Panes, FramePart::ReflectedRadiance,
                      FramePart::TransmittedRadiance, FramePart::Coats},
            .writes = {FramePart::PictureWeights, FramePart::LayerImages},
            .adds = {FramePart::Linear}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  float gate(const Frame& frame, uint32_t pixel) const;
  void behind_backward(Frame& frame, const GBuffer& buffer, size_t group) const;
  void mirrors_backward(Frame& frame, const GBuffer& buffer, size_t group) const;

  std::vector<float> reflected_;  // [h,w] sqrt of the mean of w_r C_r, for the gate
};

// Converts linear radiance to sRGB: c = srgb(clamp(gain * l, 0, 1)), as the last pass.
//   dL/dl = gain * srgb'(gain l) * dL/dc   where 0 <= gain l <= 1 (algorithms 3.6)
// Above 1 the sensor is saturated: gradients that would brighten the pixel are zero; gradients that darken it use the slope at
// 1. Below 0 the same holds with the signs swapped.
class DisplayPass final : public Pass {
 public:
  std::string_view name() const override { return "display"; }
  PassAccess access() const override { return {.reads = {FramePart::Linear}, .writes = {FramePart::Srgb}}; }
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;
};

}  // namespace vitrine
