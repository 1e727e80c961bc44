// Selects the pixels that send rays and computes their surface points (position, normal, materials) from the diffuse channels.
// Backward propagates the gradients of the points to the channels.
//
// A pixel requests reflection if alpha > min_alpha and (k_s > 1/255 or its specular mask is set), transmission likewise with
// tau and the transparent mask (which requests both). Requesting pixels are sorted so that neighbours are adjacent and split
// into as many equal groups as the budget allows; one pixel of each group, sampled from (seed, step, group), sends its rays.
//   The others use the same radiance with their own materials and propagate no gradient; the gradient of the chosen pixel
// counts for the whole group. Every pixel is chosen with probability 1/size, hence the expected gradient of a loss that is a
// sum over pixels equals the gradient with all rays traced.
//   Pixels of a coat request reflection regardless of k_s. Their rays neither move nor rotate the surfels of the paint, and f0
// remains that of the clear coat.
#pragma once

#include <memory>

#include "core/render/model/pass.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

class SurfacePass final : public Pass {
 public:
  std::string_view name() const override { return "surface"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels, FramePart::Sheets, FramePart::Coats},
            .writes = {FramePart::Surfaces, FramePart::ReflectionRequests, FramePart::TransmissionRequests}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  void select(const SplatScene& scene, Frame& frame);

  struct RayRequest {
    uint32_t pixel;
    LayersPresent layers;
  };
  std::vector<std::vector<RayRequest>> bands_;  // per row of tiles
  std::vector<float> lengths_;
};

// Rasterises the diffuse layer; later passes add to its radiance. Where known shapes represent the glass (SheetPass),
// rasterises the scene without glass instead, including the transmittance layer.
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
