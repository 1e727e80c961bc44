// Interface of a loss: a value and its gradient on the frame of one view. Losses are listed in registry.cpp; the registry gives
// each its weight option, schedule, log column and gradient tests.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/foundation/config/describe.h"
#include "core/render/raster/raster_desc.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Per-pixel targets of one view (from the user or an earlier stage), resampled to the frame. Empty = no data: a loss that needs
// it returns value 0 and no gradient, at no cost.
struct LossTargets {
  std::span<const float> specular = {};           // [h,w] in [0,1], as all masks: reflects (includes glass and mirrors)
  std::span<const float> transparent = {};        // the scene behind is visible through it
  std::span<const float> object = {};             // belongs to the captured object
  std::span<const float> ignore = {};             // no loss uses these pixels
  std::span<const float> normals = {};            // [3,h,w] unit, camera frame (a wall facing the camera is 0,0,-1); 0 = unknown
  std::span<const float> normal_confidence = {};  // [h,w] in [0,1], or empty: 1 wherever a normal is given
  std::span<const float> coat = {};               // reflects, but keeps its paint; not in `specular`
};

// Secondary rays of one kind traced for the view, in any order; one value per ray. Distances along the unit direction, from the
// ray's origin, in world units.
struct LossRays {
  std::span<const float> first_hit = {};      // where the accumulated weight first reaches a tenth; 0 = no hit
  std::span<const float> mean_distance = {};  // sum w t / sum w
  std::span<const float> alpha = {};          // sum w
  std::span<const float> wall = {};           // minimum distance of the layer's surfels; empty = 0 for every ray
  std::span<const float> weight = {};         // number of pixels a ray represents (mask, ray budget); empty = 1
};

// Inputs of a loss: planar images of one view, all [c, h, w].
struct LossInput {
  const View* view = nullptr;                   // intrinsics at the frame's size
  const RasterImages* raster = nullptr;         // diffuse pass
  std::span<const float> prediction_srgb = {};  // [3,h,w] the composited picture, display-referred
  std::span<const float> target_srgb = {};      // [3,h,w] the photo, display-referred
  std::span<const float> weight = {};           // [h,w] or empty: per-pixel weight of the picture losses
  const SplatLayer* diffuse = nullptr;          // for regularisers on parameters
  LossTargets targets = {};
  uint64_t step = 0;                            // of the run: seeds the random numbers of losses
  LossRays reflection = {}, transmission = {};  // the secondary rays of the frame
};

struct LossGradient {  // accumulated (+=)
  RasterImages* raster = nullptr;
  std::span<float> prediction_srgb = {};  // [3,h,w]
  SplatLayer* diffuse = nullptr;
  std::span<float> reflection_first_hit = {}, transmission_first_hit = {};  // one per ray; empty = not requested
};

class Loss {
 public:
  virtual ~Loss() = default;
  virtual std::string_view name() const = 0;
  // Adds `scale` times the gradient to `gradient` and returns the unscaled value.
  virtual double evaluate(const LossInput& input, double scale, LossGradient& gradient) = 0;
  virtual void describe_options(Describer&) {}  // options other than the weight
  // Whether its options leave it in at this step of a run.
  virtual bool takes_part(uint64_t) const { return true; }
};

struct LossFactory {
  std::string_view name;
  std::string_view doc;
  float default_weight;
  std::unique_ptr<Loss> (*make)();
  double default_from = 0, default_ramp = 0, default_final_share = 1;  // see WeightSchedule
};
const std::vector<LossFactory>& loss_registry();

// Perceptual loss (perceptual.cpp). `vgg`: safetensors file of the network; empty = use the option, off without it. `crop`:
// side of the compared square, pixels. `every`: steps between two evaluations; one counts for all of them.
std::unique_ptr<Loss> make_perceptual_loss(std::string vgg = {}, int crop = 128, int every = 10);

}  // namespace vitrine
