// The model as its tests hold it against finite differences and against geometry.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/render/model/layered_model.h"
#include "tests/support/gradcheck.h"

namespace vitrine {

// In double and without what is meant to alter gradients: a model that finite differences can be held against.
inline ImageOptions exact_options() {
  ImageOptions o;
  o.diffuse.backend = Backend::Reference;
  o.surface.normal_quantile = 1;
  o.composite.gate = 0;
  return o;
}

// A loss of the whole picture, and its gradient for backward().
inline double loss_of(const Frame& frame) {
  double sum = 0;
  for (float v : frame.srgb) sum += 0.5 * std::pow(double(v) - 0.3, 2);
  return sum;
}
inline void start_gradient(Frame& frame) {
  frame.grad_srgb.resize(frame.srgb.size());
  for (size_t i = 0; i < frame.srgb.size(); ++i) frame.grad_srgb[i] = frame.srgb[i] - 0.3f;
}

// `grad` has the derivatives of `loss` (which reads `scene`) by an attribute of the surfels from `first` on.
inline void expect_differences(SplatScene& scene, const SplatScene& grad, LayerKind kind, Attribute a,
                               const std::function<double()>& loss,
                               const GradTolerance& tolerance = {.relative_l2 = 2e-2, .bias = 2e-2, .row_floor = 0.05},
                               size_t first = 0) {
  const auto values = scene.layer(kind).values(a);
  const size_t begin = first * scene.layer(kind).width(a);
  const std::vector<double> differences = extrapolated_differences(values.subspan(begin), loss);
  const auto actual = grad.layer(kind).values(a).subspan(begin);
  expect_grad_close(std::vector<float>(actual.begin(), actual.end()), differences, tolerance,
                    std::string(name(kind)) + " " + std::string(row(a).name));
}

// Picture and gradients of the means are the same bytes for any number of threads.
inline void expect_same_for_threads(const ImageOptions& options, const SplatScene& scene, const View& view) {
  std::vector<std::vector<float>> pictures, gradients;
  for (int threads : {1, 3}) {
    set_thread_limit(threads);
    LayeredModel model(options);
    Frame frame;
    model.forward(scene, view, frame);
    frame.grad_srgb.assign(frame.srgb.size(), 1.f);
    SplatScene grad = scene.zeros_like();
    model.backward(scene, frame, grad);
    pictures.push_back(frame.srgb);
    const auto means = grad.diffuse.values(Attribute::Mean);
    gradients.emplace_back(means.begin(), means.end());
  }
  set_thread_limit(0);
  EXPECT_EQ(pictures[0], pictures[1]);
  EXPECT_EQ(gradients[0], gradients[1]);
}

}  // namespace vitrine
