// Silhouettes of known shapes. Surfels end in a blur, and at the edge of a specular object that blur mixes the normals and the
// materials of two things that have nothing in common; what such a pixel mirrors belongs to neither. The shape tells how much of
// a pixel it covers (outline.h), so that pixels near the silhouette show two pictures side by side,
//
//   C = c C_shape + (1 - c) C_rest        c: how much of the pixel the shape covers
//
// C_rest: the scene without the surfels that show shapes, rasterised for these pixels. C_shape: shaded like any other pixel, with
// position and normal of the shape and the materials of the nearest pixel farther inside. Where something stands in front (a
// pane), or no specular surfel shows the shape nearby, the picture stays as it was.
//
// OutlinePass gives the pixels their channels, after ShapePass; OutlineBlendPass adds C_rest, after CompositePass. Gradients
// reach the rest, the materials and, through c, the shape: photos see its silhouette.
#pragma once

#include <memory>
#include <vector>

#include "core/model/image_options.h"
#include "core/model/pass.h"

namespace vitrine {

class OutlinePass final : public Pass {
 public:
  OutlinePass(const ShapeOptions& options, const DiffuseOptions& diffuse)
      : options_(options), diffuse_(diffuse), renderer_(make_renderer(diffuse.backend)) {}
  std::string_view name() const override { return "outline"; }
  ShapeOptions& options() { return options_; }
  DiffuseOptions& diffuse() { return diffuse_; }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  void without_shapes(const SplatLayer& diffuse, const View& window);
  size_t in_window(uint32_t pixel, int width) const {
    const int x = static_cast<int>(pixel) % width - left_, y = static_cast<int>(pixel) / width - top_;
    return static_cast<size_t>(y * window_.intrinsics.width + x);
  }
  void draw_rest(const SplatScene& scene, Frame& frame);
  // The pixel farther inside whose materials `at` takes; UINT32_MAX: there is none.
  uint32_t donor(const OutlinePixel& at, const Frame& frame) const;
  bool fits(const OutlinePixel& at, const Frame& frame) const;
  void show(const OutlinePixel& at, uint32_t donor, Frame& frame) const;

  ShapeOptions options_;
  DiffuseOptions diffuse_;
  std::unique_ptr<Renderer> renderer_;
  std::vector<uint8_t> in_band_;  // [h,w]
  std::vector<uint32_t> donors_;  // [outline pixel]
  // The window of the picture that the outlines lie in, and what is drawn there.
  int left_ = 0, top_ = 0;
  View window_;
  std::vector<std::vector<uint32_t>> chunks_;
  std::vector<uint32_t> kept_;  // surfels of the diffuse layer
  SplatLayer rest_, grad_rest_;
  std::vector<uint8_t> wanted_;
  RasterImages picture_, gradients_;
  std::vector<float> blame_;
  SurfelStatistics statistics_;
};

class OutlineBlendPass final : public Pass {
 public:
  std::string_view name() const override { return "outline_blend"; }
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;
};

}  // namespace vitrine
