// Reduced photos for mask computation: enough resolution for view dependence (proposed) and for outlines (boxes).
#pragma once

#include <span>
#include <vector>

#include "core/observe/stereo/edge_field.h"
#include "stages/masks/mask_source.h"

namespace vitrine {

inline constexpr int kSmallSide = 320;  // longest side in pixels

struct SmallPhoto {
  View view;                // intrinsics at this size; gain 1 (the photo's gain is divided out)
  std::vector<float> srgb;  // [3,h,w] display-referred, in [0,1], with equal exposure in all photos
};
// `max_side` limits the longest side.
std::vector<View> small_views(const MaskCapture& capture, int max_side);
std::vector<SmallPhoto> small_photos(const MaskCapture& capture, int max_side);
EdgePhoto edge_photo(const SmallPhoto& photo);
std::vector<EdgePhoto> edge_photos(std::span<const SmallPhoto> photos);
// For edge detection: a subset of a large capture, evenly spread; some dozens of photos are enough to locate an edge.
std::vector<EdgePhoto> edge_photos(const MaskCapture& capture, int max_side);

// Gaussian, in place, of planar [channels, h, w]; clipped at the border.
void blur_planes(std::vector<float>& planes, int width, int height, float sigma);

}  // namespace vitrine
