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

}  // namespace vitrine
