// What the masks of the photos say about points of space: the rules by which a hull is carved.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/camera/view.h"

namespace vitrine {

inline constexpr double kHullInsideShare = 0.6;  // of the photos that see a point: fewer is chance
// Of those with an opinion, that a point may contradict: masks have errors, and panes have frames. More lets the hull bulge.
inline constexpr double kHullOutsideShare = 0.08;
// Of all photos with a mask, that see a point inside it: what few look at is contradicted by nobody.
inline constexpr double kHullSeenShare = 0.3;
inline constexpr int kHullFewestPhotos = 3;
inline constexpr float kHullInFront = 0.97f;  // a surface nearer than this part of a point's depth hides it

// What the masks of a photo say about a class, [h,w].
struct HullOpinion {
  std::span<const uint8_t> mask, other;  // in it; says nothing, being of another class. Empty: nowhere
};
struct HullJudge {
  const View* view;
  HullOpinion says;
  std::span<const float> depth;  // [h,w] of what is dull, 0 = none
};

}  // namespace vitrine
