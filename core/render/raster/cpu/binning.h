// Tile binning: one list of visible surfels per tile, approximately sorted by depth (README 6). Radix sort by the depth of the
// mean, exact ellipse/tile test, counting scatter. The result does not depend on the threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/foundation/base/plain_array.h"
#include "core/render/raster/cpu/raster_pass.h"

namespace vitrine::cpu {

// Mask of wanted pixels (RasterDesc::wanted), summarised per tile, block and surfel.
class WantedPixels {
 public:
  // `wanted`: [height, width]; empty: all pixels are wanted, and nothing is stored.
  void build(std::span<const uint8_t> wanted, int width, int height);

  bool all() const { return tiles_.empty(); }
  // Requires that not all pixels are wanted. Bit b: a pixel of block b is wanted.
  uint16_t blocks(size_t tile) const { return tiles_[tile].blocks; }
  // One bit per pixel of each block of the tile, in the order of lanes. [kBlocks]
  const uint16_t* pixels(size_t tile) const { return tiles_[tile].pixels; }
  // Whether a tile that overlaps this surfel's box has a wanted pixel.
  bool meets(const SplatBounds& bounds) const;

 private:
  struct Tile {
    uint16_t pixels[kBlocks];
    uint16_t blocks;
  };
  int tiles_x_ = 0;
  std::vector<Tile> tiles_;
  std::vector<uint32_t> before_;  // summed-area table of tiles with a wanted pixel, [tiles_y + 1, tiles_x + 1]
};

class TileBinning {
 public:
  // `visible`: indices into bounds, ascending. Tiles are numbered row by row; those without a wanted pixel get no surfels.
  void build(const std::vector<uint32_t>& visible, const SplatBounds* bounds, const WantedPixels& wanted, int width, int height);

  int tiles_x() const { return tiles_x_; }
  size_t tile_count() const { return tile_begin_.size() - 1; }
  size_t instance_count() const { return tile_begin_.back(); }
  uint32_t tile_begin(size_t tile) const { return tile_begin_[tile]; }
  uint32_t tile_size(size_t tile) const { return tile_begin_[tile + 1] - tile_begin_[tile]; }
  // Surfels of all tiles, tile after tile.
  const uint32_t* instances() const { return instances_.data(); }

  // Inverse map: the instances of a surfel, in tile order. `rank` is its index in the sorted order.
  const uint32_t* rank() const { return rank_.data(); }
  const uint32_t* surfel_begin() const { return surfel_begin_.data(); }  // by rank, one more than surfels
  const uint32_t* instance_of_surfel() const { return instance_of_surfel_.data(); }

 private:
  struct Chunk {                  // of consecutive surfels in sorted order
    std::vector<uint32_t> tiles;  // of each surfel, concatenated
    std::vector<uint32_t> count;  // per tile; later the next free instance
  };
  void sort_by_depth(const std::vector<uint32_t>& visible, const SplatBounds* bounds);

  int tiles_x_ = 0, tiles_y_ = 0;
  std::vector<uint32_t> order_, keys_, other_order_, other_keys_;
  std::vector<Chunk> chunks_;
  std::vector<uint32_t> tile_begin_, surfel_begin_;
  PlainArray<uint32_t> instances_, instance_of_surfel_, rank_;
};

}  // namespace vitrine::cpu
