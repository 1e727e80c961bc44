// The image model with all three layers. Its options may change between steps:
//
//   LayeredModel model(ImageOptions{...});
//   frame.specular_mask = ...; frame.transparent_mask = ...; frame.seed = seed; frame.step = step;
//   model.forward(scene, view, frame);                       // layers that are empty take no part and cost nothing
//   losses: picture -> frame.grad_srgb; channels -> frame.grad_diffuse;
//           first hits of frame.reflection / frame.transmission -> their gradients.first_hit
//   model.backward(scene, frame, grad);                      // adds to all layers of grad
//   densification: frame.statistics, frame.reflection.statistics, frame.transmission.statistics (and took_part of these two)
//
// First materials: surfels outside the masks begin with k_s and tau below 1/255 (say 0.002), or every pixel of the picture asks
// for rays and shares the budget with those that need it. Schedule: give the scene a layer when its phase begins;
// options().surface.depth_gradient, normal_gradient and options().reflection.lobe follow later. Evaluation:
// frame.differentiable = false, ray_budget = 0, Lobe::Sampled with many samples (or the lobe of the training), layer_images =
// true.
#pragma once

#include "core/render/model/image_model.h"
#include "core/render/model/shape_pass.h"

namespace vitrine {

class LayeredModel : public ImageModel {
 public:
  explicit LayeredModel(const ImageOptions& options);
  const ShapePass& shape() const { return *shape_; }  // has the gradients of the shapes

 private:
  const ShapePass* shape_;
};

}  // namespace vitrine
