// Mirrors that nobody marked. What neither stereo nor a large plane explains (core/observe/stereo/unexplained_pieces.h) is carried to all
// photos like something that was marked with boxes, and is a mirror where its places change with the view as much as the photos
// do (core/observe/stereo/view_dependence.h): those of the hull, as a thing without texture has one colour from all sides, and those that
// stereo found on it, as texture stays in its place.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "stages/masks/boxes/carried_thing.h"

namespace vitrine {

struct FoundMirror {
  CarriedThing thing;
  double of_hull = 0, of_stereo = 0;  // view dependence
  double stereo_share = 0;            // of its pixels at which stereo found a surface that is its own
};

// `desc` with stereo. Largest first; none in another.
std::vector<FoundMirror> found_mirrors(const CarryDesc& desc, std::span<const Explanation> explained,
                                       const std::function<void(double)>& progress);

}  // namespace vitrine
