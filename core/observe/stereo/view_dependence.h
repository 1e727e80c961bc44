// Measures view dependence to separate painted surfaces from mirror metal. Paint looks the same from all views, and its clear
// coat adds a few per cent of the surroundings; a point on metal varies with the view as much as the surroundings do.
//
// The measure: standard deviation of the display luminance of a point over the photos that see it, median over the points of a
// surface, divided by the standard deviation of the luminance of whole photos. 0 for matt paint, about 1 for a mirror of the
// room.
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
  ImageF luminance;             // [h,w,1] sRGB-encoded luminance in [0,1], the photo's gain removed
  std::vector<uint8_t> inside;  // [h,w] 1: the mask of the class marks the whole pixel
};

// `linear` is reduced to `side` pixels, longest side.
LuminancePhoto luminance_photo(const View& view, const ImageF& linear, int side);

// The standard deviation of the luminance over all pixels of the photos.
double luminance_spread(std::span<const LuminancePhoto> photos);

struct ViewDependenceDesc {
  std::span<const LuminancePhoto> photos;
  double photo_spread = 0;  // luminance_spread()
  // Whether another object occludes the point in the photo.
  std::function<bool(size_t photo, const Vec3d& point)> hidden;
};
// nullopt with fewer than thirty points that four photos see, and where all photos are textureless.
std::optional<double> view_dependence(std::span<const ShapePoint> surface, const ViewDependenceDesc& desc);

}  // namespace vitrine
