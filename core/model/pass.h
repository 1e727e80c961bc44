// One step of the image formation. The model runs its list of passes in order and, for gradients, the same list backwards;
// a reflection or a transmittance layer is one more pass between the diffuse one and the display.
#pragma once

#include <string_view>

#include "core/model/frame.h"
#include "core/scene/splat_scene.h"

namespace vitrine {

class Pass {
 public:
  virtual ~Pass() = default;
  virtual std::string_view name() const = 0;
  virtual void forward(const SplatScene& scene, Frame& frame) = 0;
  // Takes the gradients that later passes and the losses left in the frame one step back; adds to `grad`.
  virtual void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) = 0;
};

}  // namespace vitrine
