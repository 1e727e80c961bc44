// Per-pixel errors of one render against truth maps and photo: normals and depth, transmitted content, neutral colours.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/render/picture/view_picture.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "stages/evaluate/truth.h"

namespace vitrine {

struct SurfaceTruth {     // at render size; an empty image = unknown
  ImageF normal, zdepth;  // truth frame and units
};

struct SurfaceError {              // one entry per counted pixel: our alpha >= 1/2, truth known
  std::vector<double> normal_deg;  // angle between the normals
  std::vector<double> zdepth_rel;  // |z - z_truth| / z_truth
};
// Appends the pixels where `mask` (one channel; nullptr = everywhere) is not zero. `truth_from_ours` rotates our normals and
// scales our depth.
void add_surface_error(const ViewPicture& ours, const SurfaceTruth& truth, const Similarity& truth_from_ours, const ImageF* mask,
                       SurfaceError& sum);

double mean(const std::vector<double>& values);  // NaN when empty

// PSNR of radiance against the truth's picture of the scene without glass (transmitted radiance, over the transparent mask) or
// without its medium (over all pixels): sRGB values clipped to [0,1], at the coarser of both resolutions.
struct RadiancePicture {
  const Intrinsics& intrinsics;
  const ImageF& radiance;  // linear, before the gain
  const Vec3d& gain;       // of the view: truth pictures have the exposure of the photos
  const ImageF& mask;      // 0 or 1
};
// nullopt: fewer than `min_pixels` pixels of the mask lie in the truth's picture.
std::optional<double> radiance_psnr(const RadiancePicture& ours, const TruthPicture& truth, int min_pixels);

// Colour cast of neutral pixels: shows a wrong white balance of a view or of the scene. Compares the channels of render and photo
// in pixels that are bright, neutral and textureless in the photo (a backdrop, a plate, a wall): the largest ratio between two
// channels of (render / photo), minus 1; per channel the median over those pixels in linear light. Pictures are sRGB [h,w,3].
// `counts` [h,w,1]: pixels that are 0, or next to such a pixel, are excluded. nullopt: fewer than `min_pixels`.
std::optional<double> neutral_shift(const ImageF& srgb, const ImageF& photo_srgb, const ImageF& counts, int min_pixels);

// Pixels of held-out views: confidence of the map and absolute error, evenly spread, at most 65536 of a view.
struct ConfidenceSamples {
  std::vector<float> confidence, error;
};
// `counts` [h,w,1]: pixels that are 0 are excluded.
void add_confidence_samples(const ImageF& confidence, const ImageF& error, const ImageF& counts, ConfidenceSamples& samples);

struct ConfidenceScore {
  double mean = 0;              // confidence
  double rank_correlation = 0;  // Spearman, of confidence and minus the error
  size_t pixels = 0;
};
// nullopt: fewer than two pixels, or all have the same confidence or error.
std::optional<ConfidenceScore> confidence_against_error(const ConfidenceSamples& samples);

// Pearson correlation of the ranks; equal values share their mean rank. nullopt: fewer than two values, or one side is constant.
std::optional<double> rank_correlation(std::span<const float> a, std::span<const float> b);

}  // namespace vitrine
