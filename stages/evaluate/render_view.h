// One view of the trained scene beside its photo: gain applied, both encoded to sRGB and clipped to [0,1], because that is what
// PSNR and SSIM of the field compare. Surface maps (depth, normal) come along for the truth and the contact sheet.
#pragma once

#include <filesystem>

#include "core/camera/view.h"
#include "core/image/image.h"
#include "core/render/renderer.h"

namespace vitrine {

struct RenderedView {
  Intrinsics intrinsics;   // at render size
  ImageF srgb;             // [h, w, 3]
  ImageF zdepth;           // [h, w, 1]; 0 where alpha < 1/2
  ImageF normal_in_world;  // [h, w, 3], unit; 0 0 0 where alpha < 1/2
};

// Longest side at most `max_side`, as the optimize stage saw the view.
RenderedView rendered_view(Renderer& renderer, const SplatLayer& layer, const View& view, int max_side);
// The undistorted photo at that size: area average in linear light, then sRGB, clipped.
ImageF photo_srgb(const std::filesystem::path& sfm_folder, const View& view, const Intrinsics& intrinsics);

}  // namespace vitrine
