// Silhouettes of known shapes. Surfels end in a blur, and at the edge of a specular object that blur mixes the normals and the
// materials of two things that have nothing in common; what such a pixel mirrors belongs to neither. The shape tells how much of
// a pixel it covers (silhouette_pixels.h), so that pixels near the silhouette show two pictures side by side,
//
//   C = c C_shape + (1 - c) C_rest        c: how much of the pixel the shape covers
//
// C_rest: the scene without the surfels that show shapes, rasterised for these pixels. C_shape: shaded like any other pixel, with
// position and normal of the shape and the materials of the nearest pixel farther inside. Where something stands in front (a
// pane), or no specular surfel shows the shape nearby, the picture stays as it was.
//
// SilhouettePass gives the pixels their channels, after ShapePass; SilhouetteBlendPass adds C_rest, after CompositePass.
// Gradients reach the rest, the materials and, through c, the shape: photos see its silhouette.
#pragma once

#include <vector>

#include "core/render/model/pass.h"
#include "core/render/model/picture_window.h"
#include "core/render/model/window_picture.h"

namespace vitrine {

class SilhouettePass final : public Pass {
 public:
  explicit SilhouettePass(Backend backend) : rest_(backend) {}
  std::string_view name() const override { return "silhouette"; }
  PassAccess access() const override {
    return {.reads = {FramePart::ShownShapes, FramePart::Sheets},
            .writes = {FramePart::Silhouettes},
            .adds = {FramePart::Coats, FramePart::DiffuseChannels, FramePart::Linear},
            .reverse_adds = {FramePart::ErrorImage, FramePart::DiffuseStatistics}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  size_t in_window(uint32_t pixel, int width) const {
    return window_.index(static_cast<int>(pixel) % width, static_cast<int>(pixel) / width);
  }
  void draw_rest(const SplatScene& scene, Frame& frame);
  // The pixel farther inside whose materials `at` takes; UINT32_MAX: there is none.
  uint32_t donor(const SilhouettePixel& at, const Frame& frame) const;
  bool fits(const SilhouettePixel& at, const Frame& frame) const;
  void show(const SilhouettePixel& at, uint32_t donor, Frame& frame) const;

  ShapeOptions options_;          // of the last forward()
  std::vector<uint8_t> in_band_;  // [h,w]
  std::vector<uint32_t> donors_;  // [silhouette pixel]
  PictureWindow window_;          // that the silhouettes lie in
  WindowPicture rest_;            // what stands behind the solids, there
  std::vector<uint8_t> wanted_;
  std::vector<float> blame_;
};

class SilhouetteBlendPass final : public Pass {
 public:
  std::string_view name() const override { return "silhouette_blend"; }
  PassAccess access() const override { return {.adds = {FramePart::Silhouettes, FramePart::Linear, FramePart::LayerImages}}; }
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;
};

}  // namespace vitrine
