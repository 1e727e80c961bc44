// Lists of tiles: an instance for each pair of a tile and a surfel that touches it, sorted by tile, then by the smallest depth of
// the surfel there, then by surfel.
#pragma once

#include "core/render/raster/blocks/project_kernel.h"
#include "core/render/raster/blocks/radix_sort.h"

namespace vitrine::blocks {

// Key of an instance: the tile, then the bits of its depth, which as integers have the order of positive floats. The last bits
// are dropped: a depth that is too small by 2^-15 of itself is still a lower bound, and the sort has two passes less.
struct InstanceKey {
  static constexpr uint32_t kDropped = 8, kTileAt = 32;
  VITRINE_HD static uint64_t of(uint32_t tile, float z) {
    return uint64_t{tile} << kTileAt | (float_bits(z) >> kDropped << kDropped);
  }
  VITRINE_HD static float depth(uint64_t key) { return float_from_bits(static_cast<uint32_t>(key)); }
};

// Writes the instances of each surfel from its offset on.
struct InstanceKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  BlockView view;
  const SplatBounds* bounds;
  const uint32_t* offsets;  // of each surfel: instances of those before it
  const uint32_t* total;    // of all surfels
  SortedPairs
      instances;     // values: the place of the instance before it is sorted, surfel by surfel, each in the order of its tiles
  uint32_t* owners;  // the surfel of each place
  uint32_t surfels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= surfels) return;
    uint32_t to = offsets[i];
    if (to == (i + 1 < surfels ? offsets[i + 1] : *total)) return;
    const SortedPairs out = instances;
    uint32_t* const owner = owners;
    for_each_tile(bounds[i], view, [&](uint32_t tile, float z) {
      out.keys[to] = InstanceKey::of(tile, z);
      owner[to] = i;
      out.values[to] = to;
      ++to;
    });
  }
};

// The surfel of each sorted instance.
struct OwnerKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint32_t* places;  // of the sorted instances
  const uint32_t* owners;  // of the places
  uint32_t* surfels;
  uint32_t instances;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i < instances) surfels[i] = owners[places[i]];
  }
};

// Index of the first of `size` ascending keys that is not below `key`.
VITRINE_HD inline uint32_t first_at_least(const uint64_t* keys, uint32_t size, uint64_t key) {
  uint32_t low = 0, high = size;
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    if (keys[middle] < key)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

// begin[tile], tile = 0 ... tiles: the first instance of this tile or a later one.
struct TileBeginKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint64_t* keys;
  uint32_t* begin;
  uint32_t instances, tiles;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t tile = at.block * kThreads + at.thread;
    if (tile <= tiles) begin[tile] = first_at_least(keys, instances, uint64_t{tile} << InstanceKey::kTileAt);
  }
};

}  // namespace vitrine::blocks
