// Pinhole views cut from an equirectangular panorama: two rings of five, 90 x 90 degrees, their axes 35 degrees above and below
// the horizon of the picture, the rings 36 degrees apart. They cover the sphere up to 80 degrees of latitude; all have one
// centre.
#pragma once

#include "core/scene/camera/equirect.h"
#include "core/scene/camera/view.h"

namespace vitrine {

inline constexpr int kPanoramaViews = 10;

// view_from_panorama of view 0 to 9; the camera frame of the panorama is that of equirect.h.
Mat3d panorama_view_rotation(int view);
// As many pixels a degree in the middle of a view as the panorama has at its horizon; at most `max_side` a side (0 = no limit).
Intrinsics panorama_view_intrinsics(int panorama_width, int max_side);
// The panorama with about as many pixels a degree as the views, so that none is skipped; unchanged where it has no more.
ImageF panorama_for_views(const ImageF& panorama, const Intrinsics& view);
ImageF panorama_view(const EquirectSampler& panorama, int channels, const Intrinsics& intrinsics,
                     const Mat3d& view_from_panorama);

}  // namespace vitrine
