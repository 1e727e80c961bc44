// A loss is a value and a reverse on the frame of one view. Losses are listed in registry.cpp; the registry gives each its
// YAML block (weight + schedule + its own options), its log column and its gradient tests.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "core/camera/view.h"
#include "core/config/describe.h"
#include "core/render/raster_desc.h"
#include "core/scene/layers.h"

namespace vitrine {

// What a loss may look at: planar images of one view, all [c, h, w].
struct LossInput {
  const View* view = nullptr;                       // intrinsics at the frame's size
  const RasterImages* raster = nullptr;             // diffuse pass
  std::span<const float> prediction_srgb;           // [3,h,w] the composited picture, display-referred
  std::span<const float> target_srgb;               // [3,h,w] the photo, display-referred
  std::span<const float> weight;                    // [h,w] or empty: per-pixel weight (masks)
  const SplatLayer* diffuse = nullptr;              // for regularisers on parameters
};

struct LossGradient {                               // accumulated (+=)
  RasterImages* raster = nullptr;
  std::span<float> prediction_srgb;                 // [3,h,w]
  SplatLayer* diffuse = nullptr;
};

class Loss {
 public:
  virtual ~Loss() = default;
  virtual std::string_view name() const = 0;
  // Adds `scale` times the gradient to `gradient` and returns the unscaled value. One evaluation serves both.
  virtual double evaluate(const LossInput& input, double scale, LossGradient& gradient) = 0;
  virtual void describe_options(Describer& d) = 0;
};

struct LossFactory {
  std::string_view name;
  std::string_view doc;
  float default_weight;
  std::unique_ptr<Loss> (*make)();
  double default_from = 0, default_ramp = 0;        // parts of the run, see schedule.h
};
const std::vector<LossFactory>& loss_registry();

}  // namespace vitrine
