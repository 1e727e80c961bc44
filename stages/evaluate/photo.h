// The undistorted photo as a render is compared with it: reduced to the render's size by area average in linear light, encoded to
// sRGB and clipped to [0,1], because that is what PSNR and SSIM of the field compare.
#pragma once

#include <filesystem>

#include "core/camera/view.h"
#include "core/image/image.h"

namespace vitrine {

ImageF photo_srgb(const std::filesystem::path& sfm_folder, const View& view, const Intrinsics& intrinsics);

}  // namespace vitrine
