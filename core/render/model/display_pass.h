// Radiance to photo: c = srgb(clamp(gain * l, 0, 1)), once, at the end of the list.
//   dL/dl = gain * srgb'(gain l) * dL/dc   where 0 <= gain l <= 1 (algorithms 3.6)
// Above 1 the sensor is blind: no gradient where the picture should become brighter still, but a picture that is too bright for
// its photo must come down, so the slope at 1 is used for gradients that darken. Below 0 in the same way for gradients that
// brighten.
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
