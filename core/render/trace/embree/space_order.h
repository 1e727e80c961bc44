// Spatial order (Morton) of the surfels of a layer and the rays of a batch, so that surfels near in space are near in memory
// and are accessed at about the same time. Surfels hit consecutively by a ray, or by neighbouring rays, share cache lines.
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

// Sorts the rays of `lists`: first by the cell of the origin, then by approximate direction.
void order_rays(const RayBatch& rays, HitLists& lists);

}  // namespace vitrine::embree
