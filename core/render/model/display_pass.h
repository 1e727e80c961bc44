// Converts linear radiance to sRGB: c = srgb(clamp(gain * l, 0, 1)), as the last pass.
//   dL/dl = gain * srgb'(gain l) * dL/dc   where 0 <= gain l <= 1 (algorithms 3.6)
// Above 1 the sensor is saturated: gradients that would brighten the pixel are zero; gradients that darken it use the slope at
// 1. Below 0 the same holds with the signs swapped.
#pragma once

#include "core/render/model/pass.h"

namespace vitrine {

class DisplayPass final : public Pass {
 public:
  std::string_view name() const override { return "display"; }
  PassAccess access() const override { return {.reads = {FramePart::Linear}, .writes = {FramePart::Srgb}}; }
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;
};

}  // namespace vitrine
