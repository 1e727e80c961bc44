// A photo whose edges are looked at.
#pragma once

#include "core/camera/view.h"
#include "core/image/image.h"

namespace vitrine {

struct EdgePhoto {
  View view;    // intrinsics of the size of `srgb`
  ImageF srgb;  // [h,w,3] display-referred
};

}  // namespace vitrine
