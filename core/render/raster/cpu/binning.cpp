#include "core/render/raster/cpu/binning.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "core/foundation/base/parallel.h"

namespace vitrine::cpu {

namespace {

constexpr size_t kChunk = 2048;        // surfels
constexpr size_t kPrefetchAhead = 12;  // sorted order accesses memory randomly
constexpr int kDigitBits = 11;
constexpr uint32_t kDigits = 1u << kDigitBits;
// Two radix digits of a positive float: exponent and 14 bits of mantissa. The block lists make the order exact.
constexpr std::array<int, 2> kShifts{9, 20};

float clamp_to(float x, float low, float high) { return std::min(std::max(x, low), high); }

// The test of pass_lists.h for one rectangle of pixel centres [left, left + side] x [top, top + side].
bool hits_rectangle(const SplatBounds& b, float left, float top, float side) {
  const float x_lo = left - b.ex, y_lo = top - b.ey, x_hi = x_lo + side, y_hi = y_lo + side;
  const float x_near = clamp_to(0.f, x_lo, x_hi), y_near = clamp_to(0.f, y_lo, y_hi);
  const float y_at = clamp_to(x_near * b.shear_yx, y_lo, y_hi), x_at = clamp_to(y_near * b.shear_xy, x_lo, x_hi);
  const float across_1 = x_near - b.shear_xy * y_at, across_2 = x_at - b.shear_xy * y_near;
  const float q1 = across_1 * across_1 * b.inv_xx + y_at * y_at * b.inv_yy;
  const float q2 = across_2 * across_2 * b.inv_xx + y_near * y_near * b.inv_yy;
  const float dx = clamp_to(0.f, left - b.cx, left - b.cx + side), dy = clamp_to(0.f, top - b.cy, top - b.cy + side);
  return std::min(q1, q2) <= 1.f || dx * dx + dy * dy <= b.disc_r2;
}

}  // namespace

void TileBinning::sort_by_depth(const std::vector<uint32_t>& visible, const SplatBounds* bounds) {
  const size_t n = visible.size();
  order_ = visible;
  keys_.resize(n);
  other_order_.resize(n);
  other_keys_.resize(n);
  std::array<std::array<uint32_t, kDigits>, 2> counts{};
  for (size_t i = 0; i < n; ++i) {
    keys_[i] = std::bit_cast<uint32_t>(bounds[visible[i]].z0);
    for (size_t d = 0; d < kShifts.size(); ++d) ++counts[d][keys_[i] >> kShifts[d] & (kDigits - 1)];
  }
  for (size_t d = 0; d < kShifts.size(); ++d) {
    uint32_t begin = 0;
    for (uint32_t& c : counts[d]) begin += std::exchange(c, begin);
    for (size_t i = 0; i < n; ++i) {
      const uint32_t to = counts[d][keys_[i] >> kShifts[d] & (kDigits - 1)]++;
      other_keys_[to] = keys_[i];
      other_order_[to] = order_[i];
    }
    keys_.swap(other_keys_);
    order_.swap(other_order_);
  }
}

void TileBinning::build(const std::vector<uint32_t>& visible, const SplatBounds* bounds, const WantedPixels& wanted, int width,
                        int height) {
  tiles_x_ = (width + kTileSide - 1) / kTileSide;
  tiles_y_ = (height + kTileSide - 1) / kTileSide;
  const size_t tiles = static_cast<size_t>(tiles_x_) * static_cast<size_t>(tiles_y_);
  sort_by_depth(visible, bounds);
  const size_t n = order_.size(), chunks = chunk_count(n, kChunk);
  rank_.resize(visible.empty() ? 0 : visible.back() + size_t(1));
  chunks_.resize(chunks);
  surfel_begin_.assign(n + 1, 0);

  parallel_chunks(n, kChunk, [&](size_t c, size_t begin, size_t end) {
    Chunk& chunk = chunks_[c];
    chunk.tiles.clear();
    chunk.count.assign(tiles, 0);
    for (size_t i = begin; i < end; ++i) {
      if (i + kPrefetchAhead < end) __builtin_prefetch(bounds + order_[i + kPrefetchAhead]);
      const SplatBounds& b = bounds[order_[i]];
      const int tx0 = b.x_first / kTileSide, tx1 = b.x_last / kTileSide, ty0 = b.y_first / kTileSide, ty1 = b.y_last / kTileSide;
      const bool single = tx0 == tx1 && ty0 == ty1;
      const size_t before = chunk.tiles.size();
      for (int ty = ty0; ty <= ty1; ++ty) {
        for (int tx = tx0; tx <= tx1; ++tx) {
          const uint32_t tile = static_cast<uint32_t>(ty * tiles_x_ + tx);
          if (!wanted.all() && wanted.blocks(tile) == 0) continue;
          const float left = static_cast<float>(tx * kTileSide) + 0.5f, top = static_cast<float>(ty * kTileSide) + 0.5f;
          if (!single && !hits_rectangle(b, left, top, static_cast<float>(kTileSide - 1))) continue;
          chunk.tiles.push_back(tile);
          ++chunk.count[tile];
        }
      }
      surfel_begin_[i + 1] = static_cast<uint32_t>(chunk.tiles.size() - before);
    }
  });

  tile_begin_.assign(tiles + 1, 0);
  uint32_t next = 0;
  for (size_t t = 0; t < tiles; ++t) {
    tile_begin_[t] = next;
    for (Chunk& chunk : chunks_) next += std::exchange(chunk.count[t], next);
  }
  tile_begin_[tiles] = next;
  for (size_t i = 0; i < n; ++i) surfel_begin_[i + 1] += surfel_begin_[i];
  instances_.resize(next);
  instance_of_surfel_.resize(next);

  parallel_chunks(n, kChunk, [&](size_t c, size_t begin, size_t end) {
    Chunk& chunk = chunks_[c];
    size_t pair = 0;
    for (size_t i = begin; i < end; ++i) {
      rank_[order_[i]] = static_cast<uint32_t>(i);
      for (uint32_t k = surfel_begin_[i]; k < surfel_begin_[i + 1]; ++k) {
        const uint32_t at = chunk.count[chunk.tiles[pair++]]++;
        instances_[at] = order_[i];
        instance_of_surfel_[k] = at;
      }
    }
  });
}

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
