// A layer without some of its surfels.
#pragma once

#include <cstdint>
#include <span>

#include "core/scene/layers.h"

namespace vitrine {

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
