// The surfels of a layer along a space-filling curve, so that what is near in space is near in memory: surfels that a ray meets
// one after another, and those that neighbouring rays meet, share cache lines and pages.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/layers.h"

namespace vitrine::embree {

struct SpaceOrder {
  std::vector<uint32_t> surfel_at;  // [n] by place
  std::vector<uint32_t> place_of;   // [n] by surfel
  void build(const SplatLayer& layer);

 private:
  std::vector<uint64_t> keys_, sorted_;
};

}  // namespace vitrine::embree
