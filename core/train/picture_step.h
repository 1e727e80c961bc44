// What a frame of all layers teaches about its photo: the losses, the gradients of every layer, and the rules that hold for
// glass while surfels descend. Shared by all that train on photos.
#pragma once

#include "core/loss/loss_set.h"
#include "core/model/layered_model.h"
#include "core/train/known_surface.h"

namespace vitrine {

struct PictureTarget {
  const View* view = nullptr;
  std::span<const float> srgb;    // [3,h,w] the photo
  std::span<const float> weight;  // [h,w] or empty
  LossTargets targets;
};

// Losses of a frame that went forward, at `fraction` of the run; `grad` becomes their gradient.
LossValues learn(const PictureTarget& target, const LossSet& losses, double fraction, uint64_t step, LayeredModel& model,
                 const SplatScene& scene, Frame& frame, SplatScene& grad);

// What the last reverse says about the layer's surfels: sums over all passes that show them.
SurfelStatistics& statistics_of(Frame& frame, LayerKind kind);
// Whether a pass showed the layer in the last reverse, so that there is something to learn.
bool took_part(const Frame& frame, LayerKind kind);

// Glass stays where it is, whatever is seen through it: `damping` (of geometry and opacity, Adam::step) goes from 1 to
// `glass_factor` as a surfel is transparent, and it is not blamed for the error (`error`: of each surfel, or empty). What is no
// glass becomes none: masks reach over its rim, and what stands behind must not be taken for it.
void hold_glass(const SplatLayer& diffuse, float glass_factor, std::vector<float>& damping, std::span<float> error,
                SplatLayer& grad);

// One f0 and one k_s for all surfels of glass: their means.
void share_glass(SplatLayer& diffuse);

// Surfels near `known` stay where they are as far as they reflect: `damping` (empty: ones) is multiplied by 1 to `gloss_factor`.
// The surface is known better than a picture in a mirror tells.
void hold_gloss(const SplatLayer& diffuse, const KnownSurface& known, float gloss_factor, std::vector<float>& damping);

}  // namespace vitrine
