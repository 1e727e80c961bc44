// What one photo says about where a thing is: its mask, as seen by a camera.
#pragma once

#include <cstdint>
#include <vector>

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

// 1 where meets(pixel, eye, direction of the pixel's ray), [h,w] of the view.
template <class Meets>
std::vector<uint8_t> mask_of_rays(const View& view, const Meets& meets) {
  const Intrinsics& k = view.intrinsics;
  std::vector<uint8_t> inside(size_t(k.width) * size_t(k.height), 0);
  const Vec3d eye = view.centre_in_world();
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const size_t pixel = size_t(y) * size_t(k.width) + size_t(x);
      inside[pixel] = meets(pixel, eye, transposed_times(view.cam_from_world.rotation, k.ray(x + 0.5, y + 0.5)));
    }
  return inside;
}

}  // namespace vitrine
