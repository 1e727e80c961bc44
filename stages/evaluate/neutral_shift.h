// Does white stay white? In the pixels of a photo that are bright, neutral and without texture (a backdrop, a plate, a wall) the
// channels of the render are compared with those of the photo: a wrong white balance of a view, or of the whole scene, shows
// there.
#pragma once

#include <optional>

#include "core/image/image.h"

namespace vitrine {

// The largest ratio between two channels of (render / photo), less 1: median over those pixels of each channel in linear light.
// Pictures are sRGB [h,w,3]. `counts` [h,w,1]: pixels that are 0, or next to one that is, take no part. nullopt: fewer than
// `min_pixels`.
std::optional<double> neutral_shift(const ImageF& srgb, const ImageF& photo_srgb, const ImageF& counts, int min_pixels);

}  // namespace vitrine
