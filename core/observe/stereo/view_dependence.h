// Paint under a clear coat, or polished metal? Paint looks alike from everywhere, and its coat adds a few per cent of the
// surroundings; what a place on metal shows varies with the view as much as the surroundings do.
//
// The figure is the spread of the display luminance of a place over the photos that see it, in the median over the places of a
// surface, over the spread of the luminance of whole photos: 0 for matt paint, about 1 for a mirror of the room.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/shape/hit.h"

namespace vitrine {

// A photo, reduced.
struct LuminancePhoto {
  View view;                    // intrinsics of the size of the images
  ImageF luminance;             // [h,w,1] sRGB-encoded luminance in [0,1], the photo's gain taken out
  std::vector<uint8_t> inside;  // [h,w] 1: the mask of the class marks the whole pixel
};

// `linear` is reduced to `side` pixels, longest side.
LuminancePhoto luminance_photo(const View& view, const ImageF& linear, int side);

// The standard deviation of the luminance over all pixels of the photos.
double luminance_spread(std::span<const LuminancePhoto> photos);

struct ViewDependenceDesc {
  std::span<const LuminancePhoto> photos;
  double photo_spread = 0;  // luminance_spread()
  // Whether something else hides the point from the photo.
  std::function<bool(size_t photo, const Vec3d& point)> hidden;
};
// Thirty points are needed, each in four photos, else nullopt; likewise where all photos are blank.
std::optional<double> view_dependence(std::span<const ShapePoint> surface, const ViewDependenceDesc& desc);

}  // namespace vitrine
