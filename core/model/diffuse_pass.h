// Rasterises the diffuse layer; its colour is the radiance that the following passes add to.
#pragma once

#include <memory>

#include "core/model/pass.h"
#include "core/render/renderer.h"

namespace vitrine {

class DiffusePass final : public Pass {
 public:
  explicit DiffusePass(Backend backend = Backend::Cpu) : renderer_(make_renderer(backend)) {}
  std::string_view name() const override { return "diffuse"; }
  PassAccess access() const override { return {.writes = {FramePart::DiffuseChannels, FramePart::Linear}}; }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace vitrine
