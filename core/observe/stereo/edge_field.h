// Edge strength and direction of a photo, normalised by the local gradient. The border of a pane in front of a plain wall, two
// grey levels of contrast, counts like the edge of a poster; among tiles no edge counts much. A 3D line projects to an edge in
// all photos that see it; texture on surfaces behind it does not stay on the line in other photos.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine {

// Input photo of edge detection.
struct EdgePhoto {
  View view;    // intrinsics of the size of `srgb`
  ImageF srgb;  // [h,w,3] display-referred
};

class EdgeField {
 public:
  explicit EdgeField(const EdgePhoto& photo);

  const View& view() const { return view_; }
  // Edge strength along `direction` (world) at the projection of `p` (world): 0 none, towards 1 far above the local mean;
  // negative: `p` is outside the photo.
  float along(const Vec3d& p, const Vec3d& direction) const;

 private:
  View view_;
  ImageF tensor_;  // [h,w,3] structure tensor xx, yy, xy, relative to the local mean gradient
};

// Edge fields of the photos, reduced to a longest side of at most `max_side` pixels.
std::vector<EdgeField> edge_fields(std::span<const EdgePhoto> photos, int max_side);

}  // namespace vitrine
