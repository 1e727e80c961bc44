// Normals from an incomplete depth map: fits a plane to the reliable depths around every pixel. In a pinhole camera the inverse
// depth of a plane is linear in the pixel, 1/z = a x + b y + c, and its normal is (fx a, fy b, c + a cx + b cy) up to length and
// sign, so the fit is weighted linear least squares.
#pragma once

#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "stages/normals/normal_map.h"

namespace vitrine {

struct DepthSamples {
  int width = 0, height = 0;
  std::vector<float> inverse_z;  // [h*w]
  std::vector<float> weight;     // [h*w]; 0 = unknown
};

// `luma` [h,w,1] guides the fit: depths across an edge of the photo have a lower weight. The confidence falls with the standard
// deviation of the normal under depth noise: it is low where depths are few or one-sided.
NormalMap fitted_normals(const DepthSamples& depth, const ImageF& luma, const Intrinsics& k);

}  // namespace vitrine
