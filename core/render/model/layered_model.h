// Image model with all three layers (diffuse, reflection, transmittance). Its options may change between steps:
//
//   LayeredModel model(ImageOptions{...});
//   frame.specular_mask = ...; frame.transparent_mask = ...; frame.seed = seed; frame.step = step;
//   model.forward(scene, view, frame);                       // empty layers are skipped at no cost
//   losses: picture -> frame.grad_srgb; channels -> frame.grad_diffuse;
//           first hits of frame.reflection / frame.transmission -> their gradients.first_hit
//   model.backward(scene, frame, grad);                      // adds to all layers of grad
//   densification: frame.statistics, frame.reflection.statistics, frame.transmission.statistics (and took_part of these two)
//
// Initial materials: surfels outside the masks must start with k_s and tau below 1/255 (for example 0.002); otherwise every
// pixel requests rays and competes for the budget. Schedule: add a layer to the scene when its phase starts; enable
// options().surface.depth_gradient, normal_gradient and options().reflection.lobe later. Evaluation: frame.differentiable =
// false, ray_budget = 0, Lobe::Sampled with many samples (or the lobe of the training), layer_images = true.
#pragma once

#include "core/render/model/image_model.h"
#include "core/render/model/shape_pass.h"

namespace vitrine {

class LayeredModel : public ImageModel {
 public:
  explicit LayeredModel(const ImageOptions& options);
  const ShapePass& shape() const { return *shape_; }  // holds the gradients of the shapes

 private:
  const ShapePass* shape_;
};

}  // namespace vitrine
