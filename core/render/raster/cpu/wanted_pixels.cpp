#include "core/render/raster/cpu/wanted_pixels.h"

namespace vitrine::cpu {

void WantedPixels::build(std::span<const uint8_t> wanted, int width, int height) {
  tiles_.clear();
  if (wanted.empty()) return;
  tiles_x_ = (width + kTileSide - 1) / kTileSide;
  const int tiles_y = (height + kTileSide - 1) / kTileSide;
  const auto across = static_cast<size_t>(tiles_x_);
  tiles_.assign(across * static_cast<size_t>(tiles_y), {});
  const uint8_t* pixel = wanted.data();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (*pixel++ == 0) continue;
      Tile& tile = tiles_[static_cast<size_t>(y / kTileSide) * across + static_cast<size_t>(x / kTileSide)];
      const int block = y % kTileSide / kBlockSide * (kTileSide / kBlockSide) + x % kTileSide / kBlockSide;
      const int lane = y % kBlockSide * kBlockSide + x % kBlockSide;
      tile.pixels[block] |= static_cast<uint16_t>(1u << lane);
      tile.blocks |= static_cast<uint16_t>(1u << block);
    }
  }
  before_.assign((across + 1) * (static_cast<size_t>(tiles_y) + 1), 0);
  for (size_t y = 0; y < static_cast<size_t>(tiles_y); ++y) {
    uint32_t* row = before_.data() + (y + 1) * (across + 1);
    const uint32_t* above = row - (across + 1);
    uint32_t in_row = 0;
    for (size_t x = 0; x < across; ++x) {
      in_row += tiles_[y * across + x].blocks != 0;
      row[x + 1] = above[x + 1] + in_row;
    }
  }
}

bool WantedPixels::meets(const SplatBounds& b) const {
  const auto corner = [&](int x, int y) {
    return before_[static_cast<size_t>(y) * static_cast<size_t>(tiles_x_ + 1) + static_cast<size_t>(x)];
  };
  const int left = b.x_first / kTileSide, right = b.x_last / kTileSide + 1;
  const int top = b.y_first / kTileSide, bottom = b.y_last / kTileSide + 1;
  return corner(right, bottom) - corner(left, bottom) != corner(right, top) - corner(left, top);
}

}  // namespace vitrine::cpu
