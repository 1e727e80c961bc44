// The shape of polished things whose outlines tell it. A mirror turns its picture by twice what its normal is off, and surfels of
// polished metal, which have no texture to hold them, are off by several degrees; where the outlines in all photos are those of a
// solid of revolution (core/stereo/revolution_fit), its surface is known to a fraction of a pixel. There pixels take place and
// normal from the solid, after the diffuse layer is drawn and before anything is mirrored.
//
// A pixel takes part where the layer shows something polished, k_s above ShapeOptions::polished, that is not in front of the
// solid by more than kOnSolid_rel of its radius: an appendage, a handle. No gradient moves or turns the surfels there; what the
// mirrored rays ask of place and normal is asked of the solid: axis and profile, some hundred numbers for all photos.
#pragma once

#include <optional>
#include <vector>

#include "core/model/image_options.h"
#include "core/model/pass.h"

namespace vitrine {

class GBuffer;

class ShapePass final : public Pass {
 public:
  std::string_view name() const override { return "shape"; }
  PassAccess access() const override { return {.writes = {FramePart::ShownShapes}, .adds = {FramePart::DiffuseChannels}}; }

  // Writes the channels Normal and ZDepth of these pixels, as sums: times alpha.
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;
  const std::vector<std::vector<double>>& gradients() const { return gradients_; }  // [shape][parameter] of the last backward()
  // [vertex] of the mesh, along its normal; empty where the picture does not show it.
  const std::vector<double>& beside_gradient() const { return beside_gradient_; }

 private:
  struct Shaped {
    uint32_t pixel, shape, line;  // line: of the profile; of the mesh: the face
    float t;                      // z-depth
    Vec3f normal;
    float u = 0, v = 0;  // along the line; in the face
  };
  void beside_solids(const GBuffer& g, uint32_t pixel, std::optional<Shaped>& shown) const;
  void shape_gradients(const Frame& frame);

  ShapeOptions options_;                    // of the last forward()
  std::vector<std::vector<Shaped>> bands_;  // of the picture of the last forward(), pixels ascending
  std::vector<std::vector<double>> gradients_;
  std::vector<double> beside_gradient_;
};

}  // namespace vitrine
