// Surfels of a layer, and rays of a batch, along a space-filling curve: what is near in space is then near in memory, and looked
// at at about the same time. Surfels that a ray meets one after another, and that neighbouring rays meet, share cache lines.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/surfels/layers.h"
#include "core/render/trace/tracer.h"

namespace vitrine::embree {

struct SpaceOrder {
  std::vector<uint32_t> surfel_at;  // [n] by place
  std::vector<uint32_t> place_of;   // [n] by surfel
  void build(const SplatLayer& layer);
};

// Fills in the order of `lists`: rays that start in the same cell, then those of about the same direction.
void order_rays(const RayBatch& rays, HitLists& lists);

}  // namespace vitrine::embree
