// What one photo says about where a thing is: its mask, as seen by a camera.
#pragma once

#include "core/camera/view.h"
#include "core/image/image.h"

namespace vitrine {

struct HullMask {
  View view;    // intrinsics of the size of `mask`
  ImageF mask;  // [h,w,1]; at least one half = belongs to the object, negative = the photo does not say
  // [h,w,1] z-depth of things that may stand in front, 0 = none; empty: unknown. Outside the mask a photo says nothing about what
  // lies behind them.
  ImageF zdepth = {};
};

}  // namespace vitrine
