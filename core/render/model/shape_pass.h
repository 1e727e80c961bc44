// Replaces position and normal of specular pixels by those of known shapes (core/scene/shape). A normal error shifts a mirror
// reflection by twice its angle, and textureless surfels are off by several degrees; a shape fitted to silhouettes is accurate
// to a fraction of a pixel. Runs after the diffuse layer is rendered and before reflections.
//
// Mirror: applies to pixels with k_s above ShapeOptions::min_specular. The pixel shows the nearest hit of all shapes that is
// consistent with its depth: the depth is not in front of the shape by more than its tolerance (that is another object) nor far
// behind it (gaps of the near side show the far side). No gradient moves or rotates the surfels there; the gradient of the
// reflected rays goes to the parameters of the shape.
//   Coat: the channels keep the paint, regardless of k_s. Where the depth of the pixel is close to a shape of role Coat,
// Frame::coats stores position and normal for reflections, if the shape is exact. Such a shape is not trained.
#pragma once

#include <optional>
#include <vector>

#include "core/render/model/image_options.h"
#include "core/render/model/pass.h"

namespace vitrine {

// The known mirror shape shown at depth `z` along a ray, in units of its direction: the nearest front-facing hit consistent
// with `z`.
std::optional<ShapeSet::Hit> shown_mirror(const ShapeSet& set, const Ray& ray, double z);

class ShapePass final : public Pass {
 public:
  std::string_view name() const override { return "shape"; }
  PassAccess access() const override {
    return {.writes = {FramePart::ShownShapes, FramePart::Coats},
            .adds = {FramePart::DiffuseChannels},
            .reverse_reads = {FramePart::Surfaces, FramePart::Silhouettes}};  // gradients of the shapes
  }

  // Writes the channels Normal and ZDepth of mirrors, multiplied by alpha, and the coats.
  void forward(const SplatScene& scene, Frame& frame) override;
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) override;
  // [entry][parameter] of the last backward(); empty if its picture had no shapes.
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
  std::vector<std::vector<Shown>> bands_;  // of the last forward(), pixels ascending
  std::vector<std::vector<double>> gradients_;
};

}  // namespace vitrine
