// What is optimised: the three sets of surfels that an image model reads. A layer that does not take part is empty. A gradient
// of the scene has the same type.
#pragma once

#include <cstdint>
#include <span>

#include "core/scene/surfels/layers.h"

namespace vitrine {

struct SplatScene {
  SplatLayer diffuse;
  SplatLayer reflection{LayerKind::Reflection, 0, 0};        // what mirrors show
  SplatLayer transmittance{LayerKind::Transmittance, 0, 0};  // what stands behind and inside glass
  // The opaque twin of a scene with glass or gloss (core/render/model/opaque_pass.h): one more set of diffuse surfels that shows the
  // photos by itself. No layer: nothing of it is in the pictures of the three, and gradients have none.
  SplatLayer opaque{};

  SplatLayer& layer(LayerKind kind) {
    return kind == LayerKind::Diffuse ? diffuse : kind == LayerKind::Reflection ? reflection : transmittance;
  }
  const SplatLayer& layer(LayerKind kind) const { return const_cast<SplatScene*>(this)->layer(kind); }
  SplatScene zeros_like() const { return {diffuse.zeros_like(), reflection.zeros_like(), transmittance.zeros_like(), {}}; }
};

// The surfels with keep[i] != 0, in the old order.
inline SplatLayer kept_surfels(const SplatLayer& layer, std::span<const uint8_t> keep) {
  SplatLayer out = layer;
  size_t n = 0;
  for (size_t i = 0; i < keep.size(); ++i)
    if (keep[i]) out.copy_surfel(i, n++);
  out.resize(n);
  return out;
}

}  // namespace vitrine
