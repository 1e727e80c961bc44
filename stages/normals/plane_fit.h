// Normals from a depth map that is right in places: around every pixel a plane is fitted to the depths that can be trusted.
// Seen through a pinhole a plane's inverse depth is linear in the pixel: 1/z = a x + b y + c, and its normal is
// (fx a, fy b, c + a cx + b cy) up to length and sign, so that the fit is a weighted line fit in the picture.
#pragma once

#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "stages/normals/normal_map.h"

namespace vitrine {

struct DepthSamples {
  int width = 0, height = 0;
  std::vector<float> inverse_z;  // [h*w]
  std::vector<float> weight;     // [h*w]; 0 = nothing known there
};

// `luma` [h,w,1] guides: a depth counts less across an edge of the photo. Confidence falls with the spread of the normal that
// the noise of the depths allows, so that it is low where few depths lie, or all to one side.
NormalMap fitted_normals(const DepthSamples& depth, const ImageF& luma, const Intrinsics& k);

}  // namespace vitrine
