// Silhouettes of a rectangle in photos, and their IoU with masks.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/scene/shape/plane.h"
#include "core/observe/stereo/mask_rows.h"

namespace vitrine {

// Corners, counter-clockwise as seen from the front.
std::array<Vec3d, 4> corners_of(const Plane& plane);
bool faces(const Plane& plane, const View& view);
// The part of the rectangle in front of the camera.
RowSpans spans_of_plane(const Plane& plane, const View& view);

// The photos that constrain a rectangle, with the mask components that may be its silhouettes.
class PlaneMasks {
 public:
  // Selects the photos in front of `start` that see enough of it and whose mask is mostly known there. Mask components that the
  // start covers only slightly, and pixels outside a rectangle of 1.5 times its size, may belong to other objects: unknown.
  PlaneMasks(std::span<const Silhouette> masks, const Plane& start);
  double agreement(const Plane& plane) const {
    return agreement([&](const View& view) { return faces(plane, view) ? spans_of_plane(plane, view) : RowSpans{}; });
  }
  template <class SpansIn>  // spans_in(view)
  double agreement(const SpansIn& spans_in) const {
    std::vector<double> each(photos_.size());
    parallel_for(photos_.size(), 4, [&](size_t i) { each[i] = photos_[i].agreement(spans_in(photos_[i].view())); });
    return mean_of_better(std::move(each));
  }
  size_t marked() const;                           // number of these photos with a component
  double picture_share() const { return share_; }  // image share of `start`: mean over the photos with a component
  Vec3d mean_camera() const;

 private:
  std::vector<MaskRows> photos_;
  double share_ = 0;
};

}  // namespace vitrine
