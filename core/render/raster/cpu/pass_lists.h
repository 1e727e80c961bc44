// Converts a tile list to sixteen block lists, each in ascending z_min (README 6). One SIMD vector holds the sixteen blocks of
// the tile: the exact test "ellipse intersects rectangle of pixel centres" and the depth bounds of all blocks take a few dozen
// instructions per surfel.

namespace vitrine::VITRINE_SIMD {

using namespace vitrine::cpu;

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

// Fills the unsorted lists; also copies the tile's surfels to contiguous memory.
inline void build_lists(const TileTask& task) {
  const BlockGrid grid = block_grid(task.x0, task.y0);
  uint32_t* size = task.list_size;
  for (int b = 0; b < kBlocks; ++b) {
    task.list_offset[b] = static_cast<uint32_t>(b) * list_capacity(task.count);
    size[b] = 0;
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
    const RectangleTest<F16> t = test_rectangle(task.bounds[splat], grid.left, grid.top, float(kBlockSide - 1));
    store(z_min, t.z_min);
    for (uint32_t hits = bits(t.hit) & task.wanted_blocks; hits != 0; hits &= hits - 1) {
      const int b = __builtin_ctz(hits);
      const uint32_t to = task.list_offset[b] + size[b]++;
      task.list[to] = i;
      task.z_min[to] = z_min[b];
    }
  }
}

// Adds to each lane the number of the sixteen depths before its own. Four sums hide the latency of the additions.
template <class Before>
VITRINE_INLINE void count_before(const float* z, F16 count[4], const Before& before) {
  for (int k = 0; k < kLanes; ++k) count[k % 4] += select(before(F16(z[k]), k), F16(1.f), F16(0.f));
}

// Sorts the list of a block by z_min into task.sorted (stable). Short lists: the position of an entry is the number of entries
// before it, counted by comparing all pairs without branches. Long lists: insertion sort, since the tile's list is roughly
// sorted.
inline constexpr uint32_t kCountingSort = 256;

inline void sort_list(const TileTask& task, int block) {
  const uint32_t size = task.list_size[block];
  const uint32_t* list = task.list + task.list_offset[block];
  float* z_min = task.z_min + task.list_offset[block];
  if (size > kCountingSort) {
    for (uint32_t i = 0; i < size; ++i) {
      uint32_t at = i;
      for (; at > 0 && task.sorted_z[at - 1] > z_min[i]; --at) {
        task.sorted_z[at] = task.sorted_z[at - 1];
        task.sorted[at] = task.sorted[at - 1];
      }
      task.sorted_z[at] = z_min[i];
      task.sorted[at] = list[i];
    }
    return;
  }
  const uint32_t capacity = list_capacity(size);
  for (uint32_t i = size; i < capacity; ++i) z_min[i] = __builtin_inff();  // sorted behind all others
  const F16 lane = iota();
  for (uint32_t begin = 0; begin < size; begin += kLanes) {
    const uint32_t end = begin + kLanes < size ? begin + kLanes : size;
    const F16 z = load(z_min + begin);
    F16 places_4[4];
    for (uint32_t j = 0; j < begin; j += kLanes) count_before(z_min + j, places_4, [&](F16 other, int) { return other <= z; });
    count_before(z_min + begin, places_4,
                 [&](F16 other, int k) { return (other < z) | ((other <= z) & (lane > F16(float(k)))); });
    for (uint32_t j = begin + kLanes; j < capacity; j += kLanes)
      count_before(z_min + j, places_4, [&](F16 other, int) { return other < z; });
    const F16 place = (places_4[0] + places_4[1]) + (places_4[2] + places_4[3]);
    alignas(64) float places[kLanes];
    store(places, place);
    for (uint32_t i = begin; i < end; ++i) {
      const uint32_t to = static_cast<uint32_t>(static_cast<int>(places[i - begin]));
      task.sorted_z[to] = z_min[i];
      task.sorted[to] = list[i];
    }
  }
}

}  // namespace vitrine::VITRINE_SIMD
