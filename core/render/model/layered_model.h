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

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/render/model/medium_pass.h"
#include "core/render/model/pass.h"
#include "core/render/model/shape_pass.h"

namespace vitrine {

// Image formation as an ordered list of passes: forward renders a picture, backward computes gradients. The model owns the
// options that all of its passes read; options may change between pictures, back ends may not.

// Zeroes the statistics of every surfel and the took_part flags. ImageModel::backward() calls it first; callers that run passes
// individually must call it themselves.
void start_statistics(const SplatScene& scene, Frame& frame);

class ImageModel {
 public:
  explicit ImageModel(const ImageOptions& options) : options_(options) {}

  const ImageOptions& options() const { return options_; }
  ImageOptions& options() { return options_; }

  // Appends a pass. Error{Internal}: it reads a part that no earlier pass writes, writes a part of another pass, or changes a
  // part that an earlier pass has read.
  void add(std::unique_ptr<Pass> pass);
  template <class P, class... Arguments>
  P* emplace(Arguments&&... arguments) {
    auto pass = std::make_unique<P>(std::forward<Arguments>(arguments)...);
    P* const out = pass.get();
    add(std::move(pass));
    return out;
  }

  std::span<const std::unique_ptr<Pass>> passes() const { return passes_; }

  void forward(const SplatScene& scene, const View& view, Frame& frame) const { forward(scene, view, options_, frame); }
  // Overrides the model's options for one picture.
  void forward(const SplatScene& scene, const View& view, const ImageOptions& options, Frame& frame) const;
  // Backward of the last forward(), with its options. Sets the frame's statistics of all layers.
  void backward(const SplatScene& scene, Frame& frame, SplatScene& grad) const;

 private:
  ImageOptions options_;
  std::vector<std::unique_ptr<Pass>> passes_;
  std::vector<std::string> writer_, reader_;  // [part] name of the first pass that writes or reads it; empty: none
};

class LayeredModel : public ImageModel {
 public:
  explicit LayeredModel(const ImageOptions& options);
  const ShapePass& shape() const { return *shape_; }     // holds the gradients of the shapes
  const MediumPass& medium() const { return *medium_; }  // holds the gradient of the medium

 private:
  const ShapePass* shape_;
  const MediumPass* medium_;
};

}  // namespace vitrine
