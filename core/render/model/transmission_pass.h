// Traces the transmittance layer straight on from just behind the chosen pixels' surfaces: radiance = color, plus the residual
// transmittance of the layer. No gradient reaches the surface: a straight ray does not depend on its normal, and its hits do
// not change when its origin moves along it. Does nothing while the layer is empty, or when the glass is thin
// (TransmissionOptions::glass): then ThinGlassPass replaces it.
//   A later pass adds the radiance behind the layer: inner_transmittance * C_out to frame.transmission.radiance, and in
// backward to frame.transmission.gradients.transmittance.
#pragma once

#include <memory>

#include "core/render/model/pass.h"

namespace vitrine {

class TransmissionPass final : public Pass {
 public:
  explicit TransmissionPass(TracerBackend backend) : tracer_(make_tracer(backend)) {}
  std::string_view name() const override { return "transmission"; }
  PassAccess access() const override {
    return {.reads = {FramePart::Surfaces, FramePart::TransmissionRequests},
            .writes = {FramePart::TransmittedRadiance},
            .reverse_reads = {FramePart::PictureWeights, FramePart::ErrorImage},
            .reverse_adds = {FramePart::TransmittanceStatistics}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  std::unique_ptr<Tracer> tracer_;
  std::vector<SecondaryRay> rays_;
};

}  // namespace vitrine
