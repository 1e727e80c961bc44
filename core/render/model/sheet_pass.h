// Renders known thin and solid glass (core/scene/shape, roles Sheet and Solid) as analytic surfaces without surfels. A pixel
// with glass in front of its surfels takes normal, depth and materials from the shape, and later passes shade it as any glass
// (specular surfels at the glass are its metal frame, not glass). C_t is the radiance of the surfels there, or of refracted
// rays through a solid (ThinGlassPass), attenuated and overlaid with reflections by the Fresnel equations of thin glass or of
// one wall (README 2, 4). So glass needs no surfels, its silhouette is sharp, and its normals are those of the shape.
//
// Coverage: a pixel crossed by the silhouette of the glass is covered by the share of its four quarter-pixel centres that hit
// it; tau is that share. Glass without a known shape is not rendered, and the scene behind it remains as is.
//
// DiffusePass skips the glass surfels exported for other programs (tau above one half) where this pass is active. The channels
// overwritten by the glass receive no gradient.
#pragma once

#include <vector>

#include "core/render/model/pass.h"

namespace vitrine {

// Whether glass is rendered from its shapes.
bool draws_sheets(const ImageOptions& options);

class SheetPass final : public Pass {
 public:
  std::string_view name() const override { return "sheet"; }
  PassAccess access() const override { return {.writes = {FramePart::Sheets}, .adds = {FramePart::DiffuseChannels}}; }

  // Writes Normal, ZDepth, MedianZ, F0, Roughness, SpecularWeight, Transmission and, where larger, Alpha.
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  struct Seen {
    uint32_t entry = 0;    // 1 + index; 0: none
    uint32_t element = 0;  // of the shape
    float z = 0;
    Vec3f normal{};
  };
  void look(const Frame& frame, bool reflects);

  std::vector<Seen> middles_;  // [h,w] at the pixel centre
};

}  // namespace vitrine
