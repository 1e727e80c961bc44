// What thin glass shows of what stands behind it. A thin pane does not bend rays (algorithms 5.1), so the transmitted ray is the
// rest of the pixel's own: C_t is a picture from the same camera of everything but the glass. The opaque surfels of the diffuse
// layer and the transmittance layer are rasterised together, in exact depth order:
//
//   C_t = sum w c  over  { i in D : tau_i <= 1/2 }  and  T
//
// which is C_in + T_in C_out of the README with the diffuse layer as what lies outside. The rasteriser is the tracer's equal
// there (a test of core/render/trace says so), several times as fast, and filters what is smaller than a pixel. Things in the room so
// stay one set of surfels, whether a photo sees them directly or through the glass; the transmittance layer has what is seen
// through it only. Every pixel that asks for it has its own C_t, whichever pixels of a group send rays; the others cost nothing.
// Where known sheets stand for the glass (SheetPass), that picture is the one that DiffusePass has drawn already. Does nothing
// unless TransmissionOptions::glass is Glass::Thin and there is a layer or a sheet. Where glass is thick
// (TransmissionOptions::thick), rays bent by it take the place of the straight ones (BentRays).
#pragma once

#include <memory>
#include <vector>

#include "core/render/model/bent_rays.h"
#include "core/render/model/pass.h"

namespace vitrine {

class ThinGlassPass final : public Pass {
 public:
  // `backend`: of the rasteriser.
  explicit ThinGlassPass(Backend backend) : renderer_(make_renderer(backend)) {}
  std::string_view name() const override { return "thin_glass"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels, FramePart::Surfaces, FramePart::Sheets, FramePart::TransmissionAskers},
            .writes = {FramePart::BehindGlass},
            .adds = {FramePart::OpenedScene},
            .reverse_reads = {FramePart::PictureWeights, FramePart::ErrorImage},
            .reverse_adds = {FramePart::DiffuseStatistics, FramePart::TransmittanceStatistics}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  void take_drawn(Frame& frame) const;
  void draw(const SplatScene& scene, Frame& frame);

  std::unique_ptr<Renderer> renderer_;
  bool drawn_ = false;           // the picture is that of DiffusePass
  SplatLayer grad_;              // of the opened scene
  std::vector<uint8_t> wanted_;  // [h,w] pixels that ask for what stands behind them
  RasterImages picture_, gradients_;
  std::vector<float> blame_;
  SurfelStatistics statistics_;
  BentRays bent_;
};

}  // namespace vitrine
