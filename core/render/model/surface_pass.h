// From the diffuse channels to the surfaces that reflect or transmit: chooses the pixels that send rays and resolves what is
// there (position, normal, materials). The reverse takes the gradients of those points to the channels.
//
// A pixel asks for a reflection when alpha > min_alpha and (k_s > 1/255 or its specular mask is set), for a transmission likewise
// with tau and the transparent mask (which asks for both). Askers are put in an order in which neighbours follow each other and
// cut into as many equal groups as the budget allows; one of each group, drawn from (seed, step, group), sends its rays.
//   The others show the same radiance under their own materials, and pass no gradient; the chosen one's gradient counts for the
// whole group. Every pixel is chosen with probability 1/size, hence the expected gradient of a loss that is a sum over pixels is
// the gradient with all rays traced.
//   Pixels of a coat ask for a reflection whatever their k_s. Its rays neither move nor turn the surfels of the paint, and f0
// stays that of the clear layer.
#pragma once

#include "core/render/model/pass.h"

namespace vitrine {

class SurfacePass final : public Pass {
 public:
  std::string_view name() const override { return "surface"; }
  PassAccess access() const override {
    return {.reads = {FramePart::DiffuseChannels, FramePart::Sheets, FramePart::Coats},
            .writes = {FramePart::Surfaces, FramePart::ReflectionAskers, FramePart::TransmissionAskers}};
  }

  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;

 private:
  void select(const SplatScene& scene, Frame& frame);

  struct Asker {
    uint32_t pixel;
    LayersPresent asks;
  };
  std::vector<std::vector<Asker>> bands_;  // of each row of tiles
  std::vector<float> lengths_;
};

}  // namespace vitrine
