// Output pictures of the stage: the photo at render size, error, normal, depth and layer pictures.
#pragma once

#include <filesystem>
#include <optional>

#include "core/scene/camera/view.h"
#include "core/scene/image/contact_sheet.h"
#include "core/scene/image/image.h"
#include "core/render/picture/view_picture.h"

namespace vitrine {

// Mean absolute sRGB difference over the channels: black 0, through violet and orange to white = 0.25 and more.
Image8 error_picture(const ImageF& srgb, const ImageF& photo_srgb);
Image8 normal_picture(const ImageF& normal);  // rgb = (n + 1) / 2, black = none
// Inverse depth, near is bright (there may be a sky); 2nd to 98th percentile; black = none.
Image8 depth_picture(const ImageF& zdepth);

// Adds photo, render, error, normals and depth to the sheet. With `gain` (of the view) also one cell per layer of `picture`:
// radiance times the gain, encoded; weights as grey, 1 = white.
void add_view(const ViewPicture& picture, const ImageF& photo_srgb, const std::optional<Vec3d>& gain, ContactSheet& sheet);
// eval/<stem>_{gt,pred,err}.png
void write_pictures(const std::filesystem::path& eval_folder, const View& view, const ImageF& srgb, const ImageF& photo_srgb);
// eval/layers/<layer>/<stem>.exr
void write_layers(const std::filesystem::path& eval_folder, const View& view, const ViewPicture& picture);

// The undistorted photo at render size: area average in linear light, encoded to sRGB and clipped to [0,1], the usual values for
// PSNR and SSIM.
ImageF photo_srgb(const std::filesystem::path& sfm_folder, const View& view, const Intrinsics& intrinsics);

}  // namespace vitrine
