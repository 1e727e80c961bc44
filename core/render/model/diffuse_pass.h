// Rasterises the diffuse layer; its colour is the radiance that the following passes add to. Where known sheets stand for the
// glass (SheetPass), it rasterises everything but glass instead, the transmittance layer among it.
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
  bool opened_ = false;  // the last picture is that of Frame::opened
  SplatLayer grad_;
  SurfelStatistics statistics_;
};

}  // namespace vitrine
