// A silhouette: coverage of one object in one photo, with its camera.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct Silhouette {
  View view;     // intrinsics of the size of `value`
  ImageF value;  // [h,w,1] coverage: at least one half = object; negative = unknown
};

// From a binary mask [h,w] of the view; coverage is 0 or 1.
Silhouette silhouette(const View& view, const std::vector<uint8_t>& inside);

// Bilinear coverage at (x, y) of the photo; negative where one of the four pixels is unknown or outside.
float coverage_at(const ImageF& value, double x, double y);

// 1 where meets(pixel, eye, direction of the pixel's ray), [h,w] of the view.
template <class Meets>
std::vector<uint8_t> mask_of_rays(const View& view, const Meets& meets) {
  const Intrinsics& k = view.intrinsics;
  std::vector<uint8_t> inside(k.pixel_count(), 0);
  const Vec3d eye = view.centre_in_world();
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const size_t pixel = k.index(x, y);
      inside[pixel] = meets(pixel, eye, view.ray(x + 0.5, y + 0.5));
    }
  return inside;
}

// Silhouette of one mask class in one photo, from the files of the masks stage (core/scene/camera/view_masks.h), resized to
// `size`; nullopt: the photo has no mask of the class. Glass pixels are unknown for the other classes, since their objects are
// seen through it.
std::optional<Silhouette> mask_silhouette(const std::filesystem::path& masks, MaskClass kind, const View& photo,
                                          const Intrinsics& size);

// Whether any pixel shows an object.
bool marks_something(const Silhouette& silhouette);

// Connected components of a mask, and those that are quadrilaterals, the projections of rectangles.
struct MaskPieces {
  static constexpr uint32_t kNone = UINT32_MAX;
  std::vector<uint32_t> label;              // [h,w] component index of a marked pixel, or kNone
  std::vector<std::vector<size_t>> pixels;  // [piece]
};
MaskPieces mask_pieces(const Silhouette& mask);

// Corners in pixels, clockwise in the photo (y down).
struct Quadrilateral {
  std::array<Vec2d, 4> corners;
  double area = 0;
};
// Components of at least `least_share` of the photo, not at its border, whose convex hull is close to a quadrilateral.
// Occluders may cut off a part of an edge.
std::vector<Quadrilateral> quadrilaterals(const Silhouette& mask, double least_share);

// Counter-clockwise for y up, clockwise for y down, without points on its edges (Andrew 1979).
std::vector<Vec2d> convex_hull(std::vector<Vec2d> points);

}  // namespace vitrine
