// Exposure of relit pictures: their radiance is in the units of the lighting.
#pragma once

#include "core/scene/image/image.h"
#include "core/render/relight/lit_scene.h"

namespace vitrine {

// Stops that map the mean radiance of the mesh to middle grey, rounded to a tenth. Equal for all pictures of a lighting.
double exposure_of_scene(const LitScene& lit);

// Converts linear radiance [h, w, 3] to sRGB, brightened by `stops`.
Image8 developed(const ImageF& radiance, double stops);

}  // namespace vitrine
