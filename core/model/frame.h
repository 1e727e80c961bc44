// Everything that is known about one picture of one view while it is formed: the raster channels, the linear and the
// display-referred picture, and beside each its gradient. Passes read and write frames; planar images [c, h, w].
#pragma once

#include <vector>

#include "core/camera/view.h"
#include "core/render/raster_desc.h"
#include "core/render/renderer.h"

namespace vitrine {

struct Frame {
  const View* view = nullptr;  // pose, gains, and intrinsics at the size of the picture
  RasterImages diffuse;        // channels of the diffuse pass
  std::vector<float> linear;   // [3,h,w] radiance towards the camera, before the view's gain
  std::vector<float> srgb;     // [3,h,w] what the photo should show

  RasterImages grad_diffuse;
  std::vector<float> grad_linear, grad_srgb;
  std::vector<float> error_image;  // [h,w] or empty: what the surfels are to be blamed for (densification)
  SurfelStatistics statistics;     // of the diffuse layer, filled by the reverse of its pass

  size_t pixel_count() const {
    return static_cast<size_t>(view->intrinsics.width) * static_cast<size_t>(view->intrinsics.height);
  }
};

}  // namespace vitrine
