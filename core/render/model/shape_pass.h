// Specular pixels whose surface is a known shape (core/scene/shape). A mirror turns its picture by twice the error of its normal, and
// surfels without texture are off by several degrees; a shape that was fitted to silhouettes is right to a fraction of a pixel.
// After the diffuse layer is drawn and before anything is mirrored, these pixels take position and normal from the shape.
//
// A pixel takes part of a mirror where the layer shows something specular, k_s above ShapeOptions::polished: it shows the nearest
// hit of all shapes that its depth agrees with, not in front of the shape by more than its tolerance (another thing) nor far
// behind (gaps of the near side show the far side). No gradient moves or turns the surfels there; that of the mirrored rays goes
// to the parameters of the shape.
//   A coat keeps its paint: the channels stay as they are, whatever k_s. Where the depth of the pixel lies near a shape of role
// Coat, Frame::coats has the position and the normal for reflections, if the shape is exact. Such a shape does not learn.
#pragma once

#include <optional>
#include <vector>

#include "core/render/model/image_options.h"
#include "core/render/model/pass.h"

namespace vitrine {

// The mirror of known shape that a ray meets where surfels show something at `z`, in units of its direction: the nearest that
// faces it and that this depth agrees with.
std::optional<ShapeSet::Hit> shown_mirror(const ShapeSet& set, const Ray& ray, double z);

class ShapePass final : public Pass {
 public:
  std::string_view name() const override { return "shape"; }
  PassAccess access() const override {
    return {.writes = {FramePart::ShownShapes, FramePart::Coats},
            .adds = {FramePart::DiffuseChannels},
            .reverse_reads = {FramePart::Surfaces, FramePart::Silhouettes}};  // gradients of the shapes
  }

  // Writes the channels Normal and ZDepth of mirrors, as sums: times alpha; and the coats.
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;
  // [entry][parameter] of the last backward(); empty without shapes in its picture.
  const std::vector<std::vector<double>>& gradients() const { return gradients_; }

 private:
  struct Shown {
    uint32_t pixel;
    ShapeSet::Hit hit;  // t: z-depth
  };
  void show_mirrors(Frame& frame);
  void show_coats(Frame& frame) const;
  void shape_gradients(const Frame& frame);

  ShapeOptions options_;                   // of the last forward()
  std::vector<std::vector<Shown>> bands_;  // of the picture of the last forward(), pixels ascending
  std::vector<std::vector<double>> gradients_;
};

}  // namespace vitrine
