// Anti-aliased silhouettes of known shapes. Surfel edges are blurred; at the edge of a specular object the blur mixes the
// normals and materials of two unrelated surfaces, so the reflection there is wrong. The shape determines its coverage of a
// pixel (silhouette_pixels.h), and pixels near the silhouette blend two pictures,
//
//   C = c C_shape + (1 - c) C_rest        c: coverage of the pixel by the shape
//
// C_rest: the scene without the surfels of the shapes, rasterised for these pixels. C_shape: shaded like any other pixel, with
// position and normal of the shape and the materials of the nearest pixel farther inside. Pixels with an occluder in front (a
// pane), or without a specular surfel of the shape nearby, remain unchanged.
//
// SilhouettePass writes the channels of the pixels, after ShapePass; SilhouetteBlendPass adds C_rest, after CompositePass.
// Gradients reach C_rest, the materials and, through c, the shape: photos constrain its silhouette.
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
  // The pixel farther inside that provides the materials of `at`; UINT32_MAX: none.
  uint32_t donor(const SilhouettePixel& at, const Frame& frame) const;
  bool fits(const SilhouettePixel& at, const Frame& frame) const;
  void show(const SilhouettePixel& at, uint32_t donor, Frame& frame) const;

  ShapeOptions options_;          // of the last forward()
  std::vector<uint8_t> in_band_;  // [h,w]
  std::vector<uint32_t> donors_;  // [silhouette pixel]
  PictureWindow window_;          // bounds of the silhouettes
  WindowPicture rest_;            // scene behind the shapes, in the window
  std::vector<uint8_t> wanted_;
  std::vector<float> error_image_;
};

class SilhouetteBlendPass final : public Pass {
 public:
  std::string_view name() const override { return "silhouette_blend"; }
  PassAccess access() const override { return {.adds = {FramePart::Silhouettes, FramePart::Linear, FramePart::LayerImages}}; }
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;
};

}  // namespace vitrine
