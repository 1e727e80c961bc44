// Bounding volume hierarchy of the surfels of a layer for rays on a GPU, built on the CPU as flat arrays. Four children a node:
// their boxes and indices are then 128 bytes, one cache line of a GPU, and a thread tests them in registers. A leaf holds up to
// four surfels that follow each other in the order of the places (Morton order of the means). The hits of a ray do not depend on
// the shape of the tree.
#pragma once

#include <cstdint>
#include <vector>

#include "core/render/raster/blocks/f32.h"
#include "core/render/trace/kernels/ray_splat.h"

namespace vitrine {

class SplatLayer;

namespace blocks {

struct alignas(64) SurfelShape : RaySurfel<F32> {};

struct alignas(16) FourFloats {
  float v[4];
};

struct alignas(128) BvhNode {
  static constexpr uint32_t kChildren = 4, kLeafSize = 4;
  FourFloats planes[2][3];       // lower and upper bounds of the children by axis; of a missing child: nothing is between them
  uint32_t children[kChildren];  // index of a node, or a leaf: see below

  // A leaf: the top bit, two bits of its size less one, and its first place.
  static constexpr uint32_t kLeafBit = 1u << 31, kSizeAt = 29, kMostPlaces = 1u << kSizeAt;
  VITRINE_HD static uint32_t leaf(uint32_t first, uint32_t size) { return kLeafBit | (size - 1) << kSizeAt | first; }
  VITRINE_HD static bool is_leaf(uint32_t child) { return (child & kLeafBit) != 0; }
  VITRINE_HD static uint32_t leaf_first(uint32_t child) { return child & (kMostPlaces - 1); }
  VITRINE_HD static uint32_t leaf_size(uint32_t child) { return (child >> kSizeAt & (kLeafSize - 1)) + 1; }

  // Levels of nodes; kMostPlaces fit with the sizes that the builder permits.
  static constexpr uint32_t kLevels = 14;
  // Entries of the stack of a traversal: a node is replaced by its children.
  static constexpr uint32_t kStack = 1 + (kChildren - 1) * kLevels;
};
static_assert(sizeof(BvhNode) == 128);

struct SurfelBvh {
  static constexpr uint32_t kInvisible = ~0u;
  std::vector<BvhNode> nodes;       // the root first; none where no surfel is visible
  std::vector<SurfelShape> shapes;  // by place
  std::vector<uint32_t> surfel_at;  // by place
  std::vector<uint32_t> place_of;   // by surfel; kInvisible: too transparent, or its bounds are not finite
  float low[3] = {}, high[3] = {};  // bounds of everything
};

// Same bytes for any number of threads. Throws ExecutorOverflow above BvhNode::kMostPlaces surfels.
SurfelBvh build_surfel_bvh(const SplatLayer& layer);

}  // namespace blocks
}  // namespace vitrine
