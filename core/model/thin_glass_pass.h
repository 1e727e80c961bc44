// What thin glass shows of what stands behind it. A thin pane does not bend rays (algorithms 5.1), so the transmitted ray is the
// rest of the pixel's own: C_t is a picture from the same camera of everything but the glass. The opaque surfels of the diffuse
// layer and the transmittance layer are rasterised together, in exact depth order:
//
//   C_t = sum w c  over  { i in D : tau_i <= 1/2 }  and  T
//
// which is C_in + T_in C_out of the README with the diffuse layer as what lies outside. The rasteriser is the tracer's equal
// there (a test of core/trace says so), several times as fast, and filters what is smaller than a pixel. Things in the room so
// stay one set of surfels, whether a photo sees them directly or through the glass; the transmittance layer has what is seen
// through it only. Every pixel that asks for it has its own C_t, whichever pixels of a group send rays; the others cost nothing.
// Does nothing unless TransmissionOptions::glass is Glass::Thin and the layer is there. Where glass is thick
// (TransmissionOptions::thick), rays bent by it take the place of the straight ones (BentRays).
#pragma once

#include <memory>
#include <vector>

#include "core/model/bent_rays.h"
#include "core/model/image_options.h"
#include "core/model/pass.h"

namespace vitrine {

// Surfels of a diffuse layer that are no glass, ascending.
std::vector<uint32_t> opaque_surfels(const SplatLayer& diffuse);
// Everything but the glass in one layer: `opaque` surfels of the diffuse layer, then the transmittance layer; their spherical
// harmonics up to the degrees given (beyond: 0). Reuses the memory of `merged`.
void without_glass(const SplatScene& scene, int diffuse_degree, int layer_degree, std::vector<uint32_t>& opaque,
                   SplatLayer& merged);

class ThinGlassPass final : public Pass {
 public:
  // `diffuse`: how the diffuse layer is shown; the backend stays what it was.
  ThinGlassPass(const TransmissionOptions& options, const DiffuseOptions& diffuse)
      : options_(options), diffuse_(diffuse), renderer_(make_renderer(diffuse.backend)) {}
  std::string_view name() const override { return "thin_glass"; }
  TransmissionOptions& options() { return options_; }
  DiffuseOptions& diffuse() { return diffuse_; }
  // Of the last forward(), where it had something to show: everything but the glass, and which of it, in this order and first,
  // are surfels of the diffuse layer.
  const SplatLayer& merged() const { return merged_; }
  std::span<const uint32_t> opaque() const { return opaque_; }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  TransmissionOptions options_;
  DiffuseOptions diffuse_;
  std::unique_ptr<Renderer> renderer_;
  std::vector<uint32_t> opaque_;  // of the diffuse layer
  SplatLayer merged_, grad_;      // those, then the transmittance layer
  std::vector<uint8_t> wanted_;   // [h,w] pixels that ask for what stands behind them
  RasterImages picture_, gradients_;
  std::vector<float> blame_;
  SurfelStatistics statistics_;
  BentRays bent_;
};

}  // namespace vitrine
