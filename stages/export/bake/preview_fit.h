// Fit of an ordinary Gaussian scene to the composed pictures of all layers: the surfels of the opaque twin, or of the diffuse
// layer without a twin, with spherical harmonics fitted so that plain viewers (blending of display values, no rays) show nearly
// the same.
//
// Per channel this is linear least squares: pixel p shows  sum_ik w_ip Y_k(d_ip) h_ik  and should show the composed picture,
// encoded for display. Jacobi steps  h_ik += sum_p w_ip Y_k r_p / (S sum_p w_ip),  S = sum_k Y_k^2 = (degree + 1)^2 / 4 pi  (the
// same in every direction), never increase the squared residual, because the weights of a pixel add up to at most one.
#pragma once

#include <span>

#include "core/scene/camera/view.h"
#include "core/render/picture/trained_scene.h"

namespace vitrine {

struct PreviewFitDesc {
  int views = 16;  // fitted pictures, spread over the capture
  int max_side = 320;
  int steps = 8;
};

struct PreviewFit {
  SplatLayer surfels;                      // of display values (sRGB), not of radiance
  double psnr_before = 0, psnr_after = 0;  // of the plain pictures against the composed ones, dB
};

PreviewFit fit_preview(const TrainedScene& scene, std::span<const View> views, const PreviewFitDesc& desc);

}  // namespace vitrine
