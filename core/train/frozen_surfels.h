// Glass and mirrors while surfels descend: what is seen through or in them must not move their surfels.
#pragma once

#include <span>
#include <vector>

#include "core/scene/layers.h"
#include "core/train/known_surface.h"

namespace vitrine {

// Glass stays where it is, whatever is seen through it: `damping` (of geometry and opacity, Adam::step) goes from 1 to
// `glass_factor` as a surfel is transparent, and its `error` from all to none. What is no glass becomes none: masks reach over
// its rim, and what stands behind must not be taken for it.
void freeze_glass(const SplatLayer& diffuse, float glass_factor, std::vector<float>& damping, std::span<float> error,
                  SplatLayer& grad);

// One f0 and one k_s for all surfels of glass: their means.
void share_glass(SplatLayer& diffuse);

// Surfels near `known` stay where they are as far as they reflect: `damping` (empty: ones) is multiplied by 1 to `gloss_factor`.
// The surface is known better than a picture in a mirror tells.
void freeze_mirrors(const SplatLayer& diffuse, const KnownSurface& known, float gloss_factor, std::vector<float>& damping);

}  // namespace vitrine
