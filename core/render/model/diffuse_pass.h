// Rasterises the diffuse layer; later passes add to its radiance. Where known shapes represent the glass (SheetPass),
// rasterises the scene without glass instead, including the transmittance layer.
#pragma once

#include <memory>

#include "core/render/model/pass.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

class DiffusePass final : public Pass {
 public:
  explicit DiffusePass(Backend backend = Backend::Cpu) : renderer_(make_renderer(backend)) {}
  std::string_view name() const override { return "diffuse"; }
  PassAccess access() const override {
    return {.writes = {FramePart::DiffuseChannels, FramePart::Linear, FramePart::OpenedScene},
            .reverse_reads = {FramePart::ErrorImage},
            .reverse_adds = {FramePart::DiffuseStatistics, FramePart::TransmittanceStatistics}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  void backward_of_opened(const SplatScene& scene, Frame& frame, SplatScene& grad);

  std::unique_ptr<Renderer> renderer_;
  bool opened_ = false;  // the last picture was rendered from Frame::opened
  SplatLayer grad_;
  SurfelStatistics statistics_;
};

}  // namespace vitrine
