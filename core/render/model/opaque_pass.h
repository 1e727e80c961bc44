// Blend of the layered picture with the opaque twin (SplatScene::opaque). Scenes with glass or mirrors are trained twice: with
// all layers, and as opaque surfels only. Rays generalise as far as shapes and masks are right, the twin fails where the view
// changes; the errors of the two are nearly uncorrelated. The picture under the captured light is
//
//   C = s C_layers + (1 - s) C_twin       in linear light
//
// s is per object (ShapeSet::Entry::layered), chosen on held-out pixels of glass and mirrors, and OpaqueOptions::layered
// elsewhere. Training pictures and relit pictures use the layers only.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/render/model/pass.h"

namespace vitrine {

// [h,w] 1 + the shape entry that a pixel shows first, glass before mirrors before coats; 0: none. Pixels that SilhouettePass
// assigns to a mirror, including those crossed by its silhouette, belong to that mirror.
std::vector<uint32_t> shapes_shown(const Frame& frame);

// Radiance of the twin, [3,h,w].
class OpaquePicture {
 public:
  explicit OpaquePicture(Backend backend) : renderer_(make_renderer(backend)) {}
  std::span<const float> draw(const SplatScene& scene, const View& view, const ImageOptions& options);

 private:
  std::unique_ptr<Renderer> renderer_;
  RasterImages picture_;
};

class OpaquePass final : public Pass {
 public:
  explicit OpaquePass(Backend backend) : twin_(backend) {}
  std::string_view name() const override { return "opaque"; }
  PassAccess access() const override {
    return {.reads = {FramePart::ShownShapes, FramePart::Coats, FramePart::Silhouettes, FramePart::Sheets},
            .adds = {FramePart::Linear, FramePart::LayerImages}};
  }
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene&, Frame&, SplatScene&) override {}  // no differentiable picture is blended

 private:
  OpaquePicture twin_;
};

}  // namespace vitrine
