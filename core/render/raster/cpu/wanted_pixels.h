// Mask of wanted pixels (RasterDesc::wanted), summarised per tile, block and surfel.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/render/raster/cpu/raster_pass.h"

namespace vitrine::cpu {

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

}  // namespace vitrine::cpu
