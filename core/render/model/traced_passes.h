// Traces the reflection layer from the chosen pixels: radiance = mean over the pixel's rays of W color. Mirror rays leave along
// w = 2 (v.n) n - v with W = 1; sampled rays along GGX half vectors with the weight of kernels/ggx.h.
// Backward: through ray origin and direction to the point's position and normal, and through W to its roughness. Does nothing
// while the layer is empty.
#pragma once

#include <memory>

#include "core/render/model/pass.h"

namespace vitrine {

class ReflectionPass final : public Pass {
 public:
  explicit ReflectionPass(TracerBackend backend) : tracer_(make_tracer(backend)) {}
  std::string_view name() const override { return "reflection"; }
  PassAccess access() const override {
    return {.reads = {FramePart::Surfaces, FramePart::ReflectionRequests, FramePart::Panes},
            .writes = {FramePart::ReflectedRadiance},
            .reverse_reads = {FramePart::PictureWeights, FramePart::ErrorImage},
            .reverse_adds = {FramePart::ReflectionStatistics}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  void emit(Frame& frame, int first_sample, int last_sample);

  std::unique_ptr<Tracer> tracer_;
  std::vector<std::vector<SecondaryRay>> chunks_;
  std::vector<Vec3f> sum_;  // [groups]
  RayGradients ray_gradients_;
};

// Traces the transmittance layer straight on from just behind the chosen pixels' surfaces: radiance = color, plus the residual
// transmittance of the layer. No gradient reaches the surface: a straight ray does not depend on its normal, and its hits do
// not change when its origin moves along it. Does nothing while the layer is empty, or when the glass is thin
// (TransmissionOptions::glass): then ThinGlassPass replaces it.
//   A later pass adds the radiance behind the layer: inner_transmittance * C_out to frame.transmission.radiance, and in
// backward to frame.transmission.gradients.transmittance.
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
