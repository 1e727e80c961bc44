// The model as its tests hold it against finite differences and against geometry.
#pragma once

#include "core/model/layered_model.h"

namespace vitrine {

// In double and without what is meant to alter gradients: a model that finite differences can be held against.
inline ImageOptions exact_options() {
  ImageOptions o;
  o.diffuse.backend = Backend::Reference;
  o.surface.normal_quantile = 1;
  o.composite.gate = 0;
  return o;
}

inline void start_gradient(Frame& frame) {
  for (size_t i = 0; i < frame.srgb.size(); ++i) frame.grad_srgb[i] = frame.srgb[i] - 0.3f;
}

}  // namespace vitrine
