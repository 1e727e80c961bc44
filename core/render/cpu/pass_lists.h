// Tile list -> sixteen block lists in ascending z_min (README 6). One SIMD vector is the sixteen blocks of the tile: the exact
// test "ellipse meets rectangle of pixel centres" and the depth bounds of all blocks are a few dozen instructions per surfel.

namespace vitrine::VITRINE_SIMD {

using namespace vitrine::cpu;

inline constexpr float kDepthSlack = 1e-5f;  // rounding of z over the block
inline constexpr uint32_t kPrefetchAhead = 6;

struct BlockGrid {  // first pixel centre of each block
  F16 left, top;
};
inline BlockGrid block_grid(int x0, int y0) {
  const F16 lane = iota();
  F16 row(0.f);
  for (int r = 1; r < kBlockSide; ++r) row += select(lane >= F16(float(kBlockSide * r)), F16(1.f), F16(0.f));
  const F16 column = lane - row * F16(float(kBlockSide));
  const F16 side = F16(float(kBlockSide));
  return {F16(float(x0) + 0.5f) + side * column, F16(float(y0) + 0.5f) + side * row};
}

struct BlockTest {
  M16 hit;
  F16 z_min;
};

inline BlockTest test_blocks(const SplatBounds& b, const BlockGrid& grid) {
  const F16 zero(0.f), side(float(kBlockSide - 1));
  // The smallest value of a convex quadratic over a rectangle lies on the two edges that face its centre (or at the centre).
  const F16 x_lo = grid.left - F16(b.ex), x_hi = x_lo + side, y_lo = grid.top - F16(b.ey), y_hi = y_lo + side;
  const F16 x_near = clamp(zero, x_lo, x_hi), y_near = clamp(zero, y_lo, y_hi);
  const F16 y_at = clamp(x_near * F16(b.shear_yx), y_lo, y_hi), x_at = clamp(y_near * F16(b.shear_xy), x_lo, x_hi);
  const F16 across_1 = x_near - F16(b.shear_xy) * y_at, across_2 = x_at - F16(b.shear_xy) * y_near;
  const F16 q1 = across_1 * across_1 * F16(b.inv_xx) + y_at * y_at * F16(b.inv_yy);
  const F16 q2 = across_2 * across_2 * F16(b.inv_xx) + y_near * y_near * F16(b.inv_yy);
  const M16 ellipse = min(q1, q2) <= F16(1.f);

  const F16 dx_lo = grid.left - F16(b.cx), dy_lo = grid.top - F16(b.cy);
  const F16 dx = clamp(zero, dx_lo, dx_lo + side), dy = clamp(zero, dy_lo, dy_lo + side);
  const M16 disc = dx * dx + dy * dy <= F16(b.disc_r2);

  // 1/z is affine on the screen: its extremes over a block are at corners.
  const F16 half(0.5f * float(kBlockSide - 1));
  const F16 den = F16(1.f) + F16(b.h0) * (dx_lo + half) + F16(b.h1) * (dy_lo + half);
  const F16 reach = half * (absolute(F16(b.h0)) + absolute(F16(b.h1)));
  const F16 z0(b.z0), z_low(b.z_low), z_high(b.z_high), den_far = den + reach;
  BlockTest t;
  t.hit = ellipse | disc;
  t.z_min = select(den_far > zero, max(z0 / den_far, z_low), z_high);
  t.z_min = select(disc, min(t.z_min, z0), t.z_min) * F16(1.f - kDepthSlack);
  return t;
}

// Keeps `list` ascending: the tile's list comes roughly sorted, so that an entry moves past a few others at most.
VITRINE_INLINE void insert_sorted(ListEntry* list, uint32_t& size, ListEntry entry) {
  uint32_t at = size++;
  for (; at > 0 && list[at - 1] > entry; --at) list[at] = list[at - 1];
  list[at] = entry;
}
VITRINE_INLINE ListEntry list_entry(float z_min, uint32_t local) {
  return static_cast<ListEntry>(__builtin_bit_cast(uint32_t, z_min)) << 32 | local;
}
VITRINE_INLINE float z_min_of(ListEntry e) { return __builtin_bit_cast(float, static_cast<uint32_t>(e >> 32)); }
VITRINE_INLINE uint32_t local_of(ListEntry e) { return static_cast<uint32_t>(e); }

// Also copies the tile's surfels beside each other.
inline void build_lists(const TileTask& task) {
  const BlockGrid grid = block_grid(task.x0, task.y0);
  for (int b = 0; b < kBlocks; ++b) {
    task.list_offset[b] = static_cast<uint32_t>(b) * task.count;
    task.list_size[b] = 0;
  }
  alignas(64) float z_min[kLanes];
  for (uint32_t i = 0; i < task.count; ++i) {
    if (i + kPrefetchAhead < task.count) {
      const uint32_t ahead = task.instances[i + kPrefetchAhead];
      __builtin_prefetch(task.bounds + ahead);
      __builtin_prefetch(task.splats + ahead);
      __builtin_prefetch(reinterpret_cast<const char*>(task.splats + ahead) + 64);
    }
    const uint32_t splat = task.instances[i];
    __builtin_memcpy(task.local + i, task.splats + splat, sizeof(RasterSplat));
    const BlockTest t = test_blocks(task.bounds[splat], grid);
    store(z_min, t.z_min);
    for (uint32_t hits = bits(t.hit); hits != 0; hits &= hits - 1) {
      const int b = __builtin_ctz(hits);
      insert_sorted(task.lists + task.list_offset[b], task.list_size[b], list_entry(z_min[b], i));
    }
  }
}

}  // namespace vitrine::VITRINE_SIMD
