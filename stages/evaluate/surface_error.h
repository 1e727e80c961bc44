// Normals and depth of one render against the truth maps, pixel by pixel.
#pragma once

#include <vector>

#include "core/math/rigid.h"
#include "core/picture/view_picture.h"

namespace vitrine {

struct SurfaceTruth {     // at render size; an empty image = not known
  ImageF normal, zdepth;  // truth frame and units
};

struct SurfaceError {              // one entry per pixel that counts: our alpha >= 1/2, truth known
  std::vector<double> normal_deg;  // angle between the normals
  std::vector<double> zdepth_rel;  // |z - z_truth| / z_truth
};
// Appends the pixels where `mask` (one channel; nullptr = everywhere) is not zero. `truth_from_ours` turns our normals and scales
// our depth.
void add_surface_error(const ViewPicture& ours, const SurfaceTruth& truth, const Similarity& truth_from_ours, const ImageF* mask,
                       SurfaceError& sum);

double mean(const std::vector<double>& values);  // NaN when empty

}  // namespace vitrine
