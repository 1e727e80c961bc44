// One render against the truth maps and the photo, pixel by pixel: normals and depth, what shows behind glass, white.
#pragma once

#include <optional>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/foundation/math/rigid.h"
#include "core/render/picture/view_picture.h"
#include "stages/evaluate/truth.h"

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

// What our rays found behind the glass against the truth's picture of the scene without its glass: PSNR of sRGB values clipped to
// [0,1], over the pixels of the transparent mask, at the coarser of the two resolutions.
struct TransmittedPicture {
  const Intrinsics& intrinsics;
  const ImageF& radiance;  // linear, before the gain
  const Vec3d& gain;       // of the view: the truth's pictures are exposed like the photos
  const ImageF& mask;      // 0 or 1
};
// nullopt: fewer than `min_pixels` pixels of the mask lie in the truth's picture.
std::optional<double> transmitted_psnr(const TransmittedPicture& ours, const TruthPicture& truth, int min_pixels);

// Does white stay white? In the pixels of a photo that are bright, neutral and without texture (a backdrop, a plate, a wall) the
// channels of the render are compared with those of the photo: a wrong white balance of a view, or of the whole scene, shows
// there.
// The largest ratio between two channels of (render / photo), less 1: median over those pixels of each channel in linear light.
// Pictures are sRGB [h,w,3]. `counts` [h,w,1]: pixels that are 0, or next to one that is, take no part. nullopt: fewer than
// `min_pixels`.
std::optional<double> neutral_shift(const ImageF& srgb, const ImageF& photo_srgb, const ImageF& counts, int min_pixels);

}  // namespace vitrine
