// Transposes the pixels of a tile between image planes (a row of the tile is one vector) and blocks of 4x4 pixels (a block is
// one vector) (README 6). Whole rows are loaded at once: sixteen contiguous floats instead of four times four of each block.

namespace vitrine::VITRINE_SIMD {

using namespace vitrine::cpu;

struct PlacedTile {
  size_t width;            // of the image
  size_t first;            // pixel (x0, y0)
  uint32_t columns, rows;  // inside the image
};
inline PlacedTile placed(const PassView& view, const TileTask& task) {
  const int columns = view.width - task.x0, rows = view.height - task.y0;
  return {static_cast<size_t>(view.width), static_cast<size_t>(task.y0) * static_cast<size_t>(view.width) + task.x0,
          static_cast<uint32_t>(columns < kTileSide ? columns : kTileSide),
          static_cast<uint32_t>(rows < kTileSide ? rows : kTileSide)};
}

// The vector of a block's values of one channel, in TileTask::pixels.
inline float* block_pixels(const TileTask& task, int channel, int block) {
  return task.pixels + static_cast<size_t>(channel * kBlocks + block) * kLanes;
}

// Writes a channel of all blocks to a plane.
inline void write_plane(const PlacedTile& tile, const TileTask& task, int channel, float* plane) {
  for (uint32_t top = 0; top < tile.rows; top += kBlockSide) {
    const float* blocks = block_pixels(task, channel, static_cast<int>(top));
    F16 row[kBlockSide];
    transpose_quarters(load(blocks), load(blocks + kLanes), load(blocks + 2 * kLanes), load(blocks + 3 * kLanes), row);
    for (uint32_t r = 0; r < kBlockSide && top + r < tile.rows; ++r)
      store_first(plane + tile.first + (top + r) * tile.width, tile.columns, row[r]);
  }
}

// Reads a plane into a channel of all blocks. Zero outside the image and for a missing plane.
inline void read_plane(const PlacedTile& tile, const TileTask& task, int channel, const float* plane) {
  for (uint32_t top = 0; top < kTileSide; top += kBlockSide) {
    F16 row[kBlockSide], block[kBlockSide];
    for (uint32_t r = 0; r < kBlockSide; ++r)
      row[r] = plane != nullptr && top + r < tile.rows ? load_first(plane + tile.first + (top + r) * tile.width, tile.columns)
                                                       : F16(0.f);
    transpose_quarters(row[0], row[1], row[2], row[3], block);
    for (int b = 0; b < kBlockSide; ++b) store(block_pixels(task, channel, static_cast<int>(top) + b), block[b]);
  }
}

}  // namespace vitrine::VITRINE_SIMD
