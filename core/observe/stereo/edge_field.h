// Where a photo changes, and in which direction, as strong as that stands out of what surrounds it: the rim of a pane before a
// plain wall, which differs from it by two grey levels, counts like the edge of a poster, and among tiles nothing counts much. A
// line in space is an edge in all photos that show it; what is drawn on things behind it is not on that line in any other photo.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"

namespace vitrine {

// A photo whose edges are looked at.
struct EdgePhoto {
  View view;    // intrinsics of the size of `srgb`
  ImageF srgb;  // [h,w,3] display-referred
};

class EdgeField {
 public:
  explicit EdgeField(const EdgePhoto& photo);

  const View& view() const { return view_; }
  // How much of an edge along `direction` (world) there is at the picture of `p` (world): 0 none, towards 1 far more than around
  // it; negative: the photo does not show `p`.
  float along(const Vec3d& p, const Vec3d& direction) const;

 private:
  View view_;
  ImageF tensor_;  // [h,w,3] of squared changes: along x, along y, mixed; of the mean change around
};

// Of photos with a longest side of at most `max_side` pixels.
std::vector<EdgeField> edge_fields(std::span<const EdgePhoto> photos, int max_side);

}  // namespace vitrine
