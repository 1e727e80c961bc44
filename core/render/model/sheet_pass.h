// Known sheets and blocks of clear glass (core/scene/shape, roles Sheet and Solid) stand over the picture as surfaces of their own: no
// surfel shows them. A pixel that looks at a pane in front of what the surfels show takes normal, depth and materials from the
// shape, and later passes shade it as they shade any glass (metal that the surfels show at the sheet is its frame, no glass). C_t
// is what the surfels show there, or what bent rays through a block show (ThinGlassPass), dimmed and mirrored over by the Fresnel
// law of a sheet or of one wall (README 2, 4). So glass takes no surfel of the budget, its silhouette is sharp, and its normals
// are those of the shape.
//
// Coverage: pixels that the silhouette of a sheet crosses are covered by the share of their four quarters whose middles meet it;
// tau is that share. Where nothing is known of glass (no shape), nothing is drawn, and what is seen through it stays as it is.
//
// Surfels that carry the glass for other programs (tau above one half) are not drawn by DiffusePass where this pass acts. No
// gradient reaches the channels that the sheet overwrites.
#pragma once

#include <vector>

#include "core/render/model/pass.h"

namespace vitrine {

// Whether glass is drawn from its shapes.
bool draws_sheets(const ImageOptions& options);

class SheetPass final : public Pass {
 public:
  std::string_view name() const override { return "sheet"; }
  PassAccess access() const override { return {.writes = {FramePart::Sheets}, .adds = {FramePart::DiffuseChannels}}; }

  // Writes Normal, ZDepth, MedianZ, F0, Roughness, SpecularWeight, Transmission and, where it is more, Alpha.
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

  std::vector<Seen> middles_;  // [h,w] at the pixel's middle
};

}  // namespace vitrine
