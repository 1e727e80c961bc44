// Transmission through thin glass, rasterised. A thin pane does not refract rays (algorithms 5.1), so the transmitted ray
// continues the camera ray: C_t is the picture of the scene without glass from the same camera. The opaque surfels of the
// diffuse layer and the transmittance layer are rasterised together, in exact depth order:
//
//   C_t = sum w c  over  { i in D : tau_i <= 1/2 }  and  T
//
// This equals C_in + T_in C_out of the README with the diffuse layer as the outside. The rasteriser matches the tracer there
// (tested in core/render/trace), is several times faster, and filters details below a pixel. Objects in the room are thus one
// set of surfels, whether a photo sees them directly or through the glass; the transmittance layer contains only what is seen
// through it. Every requesting pixel has its own C_t, whichever pixels of a group send rays; other pixels cost nothing. Where
// known shapes represent the glass (SheetPass), DiffusePass has already rendered this picture. Does nothing unless
// TransmissionOptions::glass is Glass::Thin and there is a layer or known glass. Where glass is thick
// (TransmissionOptions::thick), refracted rays replace the straight ones (BentRays).
#pragma once

#include <memory>
#include <vector>

#include "core/render/model/bent_rays.h"
#include "core/render/model/pass.h"

namespace vitrine {

class ThinGlassPass final : public Pass {
 public:
  explicit ThinGlassPass(Backend backend) : renderer_(make_renderer(backend)) {}
  std::string_view name() const override { return "thin_glass"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels, FramePart::Surfaces, FramePart::Sheets, FramePart::TransmissionRequests},
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
  bool drawn_ = false;           // the picture was rendered by DiffusePass
  SplatLayer grad_;              // of the scene without glass
  std::vector<uint8_t> wanted_;  // [h,w] pixels that request transmission
  RasterImages picture_, gradients_;
  std::vector<float> error_image_;
  SurfelStatistics statistics_;
  BentRays bent_;
};

}  // namespace vitrine
