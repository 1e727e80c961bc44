// Normals and depth of one render against the truth maps, pixel by pixel, outside the glass.
#pragma once

#include <vector>

#include "core/math/rigid.h"
#include "core/picture/view_picture.h"

namespace vitrine {

struct SurfaceTruth {          // at render size; an empty image = not known
  ImageF normal, zdepth;       // truth frame and units
  ImageF transparent, object;  // masks of 0 and 1
};

struct SurfaceError {                     // one entry per pixel that counts
  std::vector<double> normal_deg;         // angle between the normals; opaque, truth normal known, not transparent
  std::vector<double> object_normal_deg;  // the same, object mask only
  std::vector<double> zdepth_rel;         // |z - z_truth| / z_truth
};
// Appends; `truth_from_ours` turns our normals and scales our depth.
void add_surface_error(const ViewPicture& ours, const SurfaceTruth& truth, const Similarity& truth_from_ours, SurfaceError& sum);

double mean(const std::vector<double>& values);  // NaN when empty

}  // namespace vitrine
