// Where photos show a rectangle, and how its silhouettes agree with masks.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/scene/shape/plane.h"
#include "core/observe/stereo/mask_rows.h"

namespace vitrine {

// Corners in the order of a walk around it: counter-clockwise as seen from its front.
std::array<Vec3d, 4> corners_of(const Plane& plane);
bool faces(const Plane& plane, const View& view);
// The part of it in front of the camera.
RowSpans spans_of_plane(const Plane& plane, const View& view);

// The photos that tell something about a rectangle, with the pieces of their masks that may be its silhouettes.
class PlaneMasks {
 public:
  // About `start`: a photo counts that looks at its front, has enough of it in the picture, and whose mask is known there for
  // the most part. Pieces of the mask of which the start covers little, and pixels outside of a
  // rectangle of 1.5 times its size, may be of other things: unknown.
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
  size_t marked() const;                           // of the photos, that show a piece
  double picture_share() const { return share_; }  // of the start, in the photos that show a piece: mean
  Vec3d mean_camera() const;

 private:
  std::vector<MaskRows> photos_;
  double share_ = 0;
};

}  // namespace vitrine
