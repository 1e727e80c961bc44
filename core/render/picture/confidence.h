// Confidence of the surfels of a trained scene, from its training photos: which photos see a surfel and from how far apart
// (coverage), and by how much their renders differ from the photos where the surfel shows (residual). `view.html` shows the
// coverage; evaluation, files and the report the confidence, which joins the two.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/render/picture/view_picture.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Surfels seen by few photos, or from one side only, are badly constrained.
struct PhotoCoverage {
  int photos = 0;
  double widest_deg = 0;  // largest angle at the surfel between two of them
};

// A photo sees a surfel if its centre is inside the image and at least 5 % of its unoccluded blending weight remains. The first
// `solid` surfels are those that are not glass: glass occludes only surfels of glass.
std::vector<PhotoCoverage> photo_coverage(const SplatLayer& layer, size_t solid, std::span<const View> photos, float near_z);

struct TrainingEvidence {
  std::vector<double> weight;  // [surfels] blending weight, summed over pixels and photos
  std::vector<double> error;   // [surfels] mean absolute sRGB difference of the channels, times that weight, summed
};

// Confidence of each surfel in (0, 1]; 0: no training photo shows it.
std::vector<float> confidence_of(const TrainingEvidence& evidence);

// Over the diffuse surfels of the painter's scene, at most 320 pixels a side. `photo_of`: the photo of a view at the size of its
// intrinsics, sRGB in [0, 1].
std::vector<float> surfel_confidence(ScenePainter& painter, std::span<const View> training,
                                     const std::function<ImageF(const View&)>& photo_of);

// The confidence as a map of a view, [h, w, 1]; 0 where there is no surface.
ImageF confidence_map(const SplatLayer& diffuse, std::span<const float> confidence, float near_z, const View& view);

// Mean absolute difference of the channels, [h, w, 1].
ImageF absolute_error(const ImageF& srgb, const ImageF& reference_srgb);

}  // namespace vitrine
