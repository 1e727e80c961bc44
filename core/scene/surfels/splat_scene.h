// Optimised scene: the three surfel layers read by the image model. Unused layers are empty. Gradients of the scene have the
// same type.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "core/scene/surfels/layers.h"

namespace vitrine {

struct SplatScene {
  SplatLayer diffuse;
  SplatLayer reflection{LayerKind::Reflection, 0, 0};        // reflected radiance of mirrors
  SplatLayer transmittance{LayerKind::Transmittance, 0, 0};  // surfaces behind and inside glass
  // Opaque twin of a scene with glass or specular objects (core/render/model/opaque_pass.h): a second set of diffuse surfels
  // that reproduces the photos alone. If absent, it contributes nothing to images or gradients.
  SplatLayer opaque{};

  SplatLayer& layer(LayerKind kind) {
    return kind == LayerKind::Diffuse ? diffuse : kind == LayerKind::Reflection ? reflection : transmittance;
  }
  const SplatLayer& layer(LayerKind kind) const { return const_cast<SplatScene*>(this)->layer(kind); }
  SplatScene zeros_like() const { return {diffuse.zeros_like(), reflection.zeros_like(), transmittance.zeros_like(), {}}; }
};

// Surfels with keep[i] != 0, in the original order.
inline SplatLayer kept_surfels(const SplatLayer& layer, std::span<const uint8_t> keep) {
  SplatLayer out = layer;
  size_t n = 0;
  for (size_t i = 0; i < keep.size(); ++i)
    if (keep[i]) out.copy_surfel(i, n++);
  out.resize(n);
  return out;
}

// Scene files: one binary PLY per layer with the raw values of every attribute row, bit-exact round trip. Object ids, if known,
// are the last property, object_id.
void write_layer(const std::filesystem::path& path, const SplatLayer& layer);
// Throws Error{Input} with file and cause (truncated, unknown layer, wrong property, non-finite value, absurd count).
SplatLayer read_layer(const std::filesystem::path& path);

}  // namespace vitrine
