// Detection of unmarked mirrors. A piece that neither stereo nor a large plane explains
// (core/observe/stereo/unexplained_pieces.h) is propagated to all photos like an object marked with boxes. It is a mirror if both
// kinds of its surface points are as view-dependent as the photos vary (core/observe/stereo/view_dependence.h): those of the hull
// (an untextured surface has one colour from all sides) and those that stereo found on it (texture stays in place). The light must
// not move with the camera: the flash of a camera makes matt surfaces view-dependent.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "stages/masks/boxes/carried_object.h"

namespace vitrine {

struct FoundMirror {
  CarriedObject object;
  double of_hull = 0, of_stereo = 0;  // view dependence
  double stereo_share = 0;            // share of its pixels at which stereo found a surface of its own
};

// Requires `desc.stereo`. Largest first; none inside another.
std::vector<FoundMirror> found_mirrors(const CarryDesc& desc, std::span<const Explanation> explained,
                                       const std::function<void(double)>& progress);

}  // namespace vitrine
