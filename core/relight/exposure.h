// Relit radiance as people look at it: in the units of the light, so that a picture needs an exposure of its own.
#pragma once

#include "core/image/image.h"
#include "core/relight/lit_scene.h"

namespace vitrine {

// Stops that make the mean of what the mesh sends on a middle grey, to a tenth. The same for all pictures of a light.
double exposure_of_scene(const LitScene& lit);

// sRGB of linear radiance, [h, w, 3], so many stops brighter.
Image8 developed(const ImageF& radiance, double stops);

}  // namespace vitrine
