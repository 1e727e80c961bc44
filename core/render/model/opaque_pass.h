// A scene with glass or gloss is trained twice: with all layers, and as opaque surfels alone (SplatScene::opaque, its opaque
// twin). Rays generalise as far as shapes and masks are right, the twin fails where the view changes; errors of the two, and what
// is accidental in either, have little in common. A picture of the scene as photographed is
//
//   C = s C_layers + (1 - s) C_twin       in linear light
//
// with s by object (ShapeSet::Entry::layered), chosen on glass and gloss that neither was trained on, and OpaqueOptions::layered
// elsewhere. Pictures that somebody learns from, and pictures under another light, are those of the layers.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/render/model/pass.h"

namespace vitrine {

// [h,w] 1 + the entry of the set of shapes that a pixel shows first, glass before mirrors before coats; 0: none. Pixels that
// SilhouettePass gives to a mirror, those that its silhouette crosses among them, belong to it.
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
