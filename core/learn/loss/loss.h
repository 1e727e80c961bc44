// A loss is a value and a reverse on the frame of one view. Losses are listed in registry.cpp; the registry gives each the
// option of its weight, its schedule, its log column and its gradient tests.
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

// What the user or an earlier stage says about the pixels of one view, resampled to the frame. Empty = nobody said anything,
// and a loss that needs it is silent: value 0, no gradient, no cost.
struct LossTargets {
  std::span<const float> specular = {};           // [h,w] in [0,1], each mask likewise: reflects (includes glass and metal)
  std::span<const float> transparent = {};        // something is seen through it
  std::span<const float> object = {};             // belongs to the captured object
  std::span<const float> ignore = {};             // no loss looks at these pixels
  std::span<const float> normals = {};            // [3,h,w] unit, camera frame (a wall facing the camera is 0,0,-1); 0 = unknown
  std::span<const float> normal_confidence = {};  // [h,w] in [0,1], or empty: 1 wherever a normal is known
  std::span<const float> coat = {};               // reflects, but keeps its paint; not in `specular`
};

// Secondary rays of one kind that were traced for the view, in any order; one value per ray. Distances along the unit
// direction, from the ray's origin, in world units.
struct LossRays {
  std::span<const float> first_hit = {};      // where the accumulated weight first reaches a tenth; 0 = the ray met nothing
  std::span<const float> mean_distance = {};  // sum w t / sum w
  std::span<const float> alpha = {};          // sum w
  std::span<const float> wall = {};           // nothing of the layer belongs before this distance; empty = 0 for every ray
  std::span<const float> weight = {};         // how many pixels a ray stands for (mask, ray budget); empty = 1
};

// What a loss may look at: planar images of one view, all [c, h, w].
struct LossInput {
  const View* view = nullptr;                   // intrinsics at the frame's size
  const RasterImages* raster = nullptr;         // diffuse pass
  std::span<const float> prediction_srgb = {};  // [3,h,w] the composited picture, display-referred
  std::span<const float> target_srgb = {};      // [3,h,w] the photo, display-referred
  std::span<const float> weight = {};           // [h,w] or empty: per-pixel weight of the picture losses
  const SplatLayer* diffuse = nullptr;          // for regularisers on parameters
  LossTargets targets = {};
  uint64_t step = 0;                            // of the run: what a loss draws at random depends on it
  LossRays reflection = {}, transmission = {};  // the secondary rays of the frame
};

struct LossGradient {  // accumulated (+=)
  RasterImages* raster = nullptr;
  std::span<float> prediction_srgb = {};  // [3,h,w]
  SplatLayer* diffuse = nullptr;
  std::span<float> reflection_first_hit = {}, transmission_first_hit = {};  // one per ray; empty = not wanted
};

class Loss {
 public:
  virtual ~Loss() = default;
  virtual std::string_view name() const = 0;
  // Adds `scale` times the gradient to `gradient` and returns the unscaled value. One evaluation serves both.
  virtual double evaluate(const LossInput& input, double scale, LossGradient& gradient) = 0;
  virtual void describe_options(Describer&) {}  // its options other than the weight
};

struct LossFactory {
  std::string_view name;
  std::string_view doc;
  float default_weight;
  std::unique_ptr<Loss> (*make)();
  double default_from = 0, default_ramp = 0, default_final_share = 1;  // see WeightSchedule
};
const std::vector<LossFactory>& loss_registry();

// Perceptual loss (perceptual.cpp). `vgg`: safetensors file of the network; empty = the option decides, off without it.
// `crop`: side of the square that is compared, pixels. `every`: steps between two evaluations; one counts for all of them.
std::unique_ptr<Loss> make_perceptual_loss(std::string vgg = {}, int crop = 128, int every = 10);

}  // namespace vitrine
