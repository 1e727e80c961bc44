// Parts of a picture that are scored apart: glass (transparent), mirrors and gloss (specular), the object, and the rest = in
// neither the transparent nor the specular class. An opaque method is judged on the rest.
#pragma once

#include <map>
#include <string>

#include "stages/evaluate/truth.h"

namespace vitrine {

// Region name -> one channel of 0 and 1 at render size. Absent: no mask file of that class for this view; `rest` is there when
// the transparent or the specular mask is.
using RegionMasks = std::map<std::string, ImageF>;
RegionMasks region_masks(const Truth& truth, size_t view, const Intrinsics& intrinsics);

// PSNR of each region with at least `min_pixels` pixels: squared error pooled over the region's pixels and channels.
std::map<std::string, double> region_psnr(const RegionMasks& masks, const ImageF& srgb, const ImageF& photo_srgb, int min_pixels);

}  // namespace vitrine
