// Forward pass of a tile: blocks of 4x4 pixels, exact depth order per pixel without sorting pixels (README 6).
//
// Only the transmittance in front of a fragment depends on the order; sums do not. Surfels come in ascending z_min, which is
// nearly the depth order of most pixels: a new fragment is attenuated by the product over all earlier ones, unless it lies in
// front of the deepest of them in some pixel. Then the loop goes back over the fragments that it may precede, and resolves the
// order of each pair per lane.

namespace vitrine::VITRINE_SIMD {

struct BlockPlace {
  F16 px, py;
  F16 inside;  // 1 in the image, 0 outside and in unwanted pixels
};
inline BlockPlace block_place(const PassView& view, const TileTask& task, int block) {
  const F16 lane = iota();
  F16 row(0.f);
  for (int r = 1; r < kBlockSide; ++r) row += select(lane >= F16(float(kBlockSide * r)), F16(1.f), F16(0.f));
  const F16 column = lane - row * F16(float(kBlockSide));
  const int x = task.x0 + kBlockSide * (block % kBlockSide), y = task.y0 + kBlockSide * (block / kBlockSide);
  BlockPlace p;
  p.px = F16(float(x) + 0.5f) + column;
  p.py = F16(float(y) + 0.5f) + row;
  M16 inside = (p.px < F16(float(view.width))) & (p.py < F16(float(view.height)));
  if (task.wanted != nullptr) inside = inside & mask_from_bits(task.wanted[block]);
  p.inside = select(inside, F16(1.f), F16(0.f));
  return p;
}

inline constexpr float kFarAway = 1e30f;        // z where a surfel has no fragment
inline constexpr float kOpaqueEnough = 1e-10f;  // lower clamp of transmittances: far below any cut, far above denormals

// The backward search advances by this many slots and always checks the first: checking more than needed is harmless, and there
// are fewer branches to predict. As many slots, plus one, in front of the first surfel represent the eye.
inline constexpr uint32_t kStride = 4;

// One surfel in a block.
struct alignas(64) Fragment {
  F16 alpha, transmittance, z;
  F16 through;  // transmittance behind this and all earlier slots
  F16 deepest;  // largest z up to here
  const RasterSplat* splat;
  uint32_t id;
  int32_t compared_from;  // earlier slots lie in front in all pixels

  void be_the_eye(F16 inside) {
    alpha = z = deepest = F16(0.f);
    through = max(inside, F16(kOpaqueEnough));
    id = 0;
  }
};

// Whether a new fragment lies in front of older ones, by (z, id).
struct DepthOrder {
  F16 limit[2];
  uint32_t id;
  explicit DepthOrder(const Fragment& f) : limit{f.z, next_above(f.z)}, id(f.id) {}
  VITRINE_INLINE M16 before(const Fragment& older) const { return limit[older.id < id ? 1 : 0] <= older.z; }
};

// Surfels are evaluated in batches without branches, which would be unpredictable and wait for a long chain of arithmetic; then
// their order is resolved one by one.
inline constexpr uint32_t kBatch = 8;

// Inserts slot n, whose alpha, z and id are set, into the depth order of the slots before it.
template <class Slot>
VITRINE_INLINE void settle(Slot* slots, uint32_t n) {
  Slot& f = slots[n];
  const Slot& last = slots[n - 1];
  const F16 transparency = F16(1.f) - f.alpha;
  f.deepest = max(last.deepest, select(f.alpha > F16(0.f), f.z, F16(0.f)));
  f.through = max(last.through * transparency, F16(kOpaqueEnough));
  const DepthOrder order(f);
  F16 dimming(1.f);
  Slot* older = slots + n;
  do {
    older -= kStride;
    for (int j = int(kStride) - 1; j >= 0; --j) {
      Slot& o = older[j];
      const M16 first = order.before(o);
      dimming = dim_where(~first, dimming, o.alpha);
      o.transmittance = multiply_where(first, o.transmittance, transparency);
    }
  } while (any(f.z <= older[-1].deepest));
  f.transmittance = older[-1].through * dimming;
  f.compared_from = static_cast<int32_t>(older - slots);
}

template <int F, bool kDistortion>
struct ForwardBlock {
  F16 features[F];
  F16 zdepth, alpha, median_z, q1, q2, pivot;

  VITRINE_INLINE void add(const Fragment& f) {
    const F16 w = blend_weight(f.alpha, f.transmittance);
    for (int c = 0; c < F; ++c) features[c] += w * F16(f.splat->features[c]);
    zdepth += w * f.z;
    alpha += w;
    median_z = select((f.transmittance > F16(float(kMedianTransmittance))) & (f.alpha > F16(0.f)), max(median_z, f.z), median_z);
    if constexpr (kDistortion) {
      const F16 q = reciprocal(f.z) - pivot, wq = w * q;
      q1 += wq;
      q2 += wq * q;
    }
  }
};

template <int F, bool kDistortion>
void forward_block(const PassView& view, const TileTask& task, int block) {
  const BlockPlace place = block_place(view, task, block);
  const uint32_t size = task.list_size[block];
  sort_list(task, block);
  uint32_t* seen = task.list + task.list_offset[block];  // reuses the memory of the unsorted list
  Fragment* slots = reinterpret_cast<Fragment*>(task.slots);
  for (uint32_t i = 0; i <= kStride; ++i) slots[i].be_the_eye(place.inside);
  slots += kStride;                                          // the first surfel is slot 1
  uint32_t used = 0, final = 0, fragments = 0, vectors = 0;  // `final`: slots in front of all later ones
  for (uint32_t begin = 0; begin < size; begin += kBatch) {
    const F16 z_min(task.sorted_z[begin]);
    while (final < used && !any(slots[final + 1].deepest >= z_min)) ++final;
    const M16 open = slots[final].through >= F16(float(kMinTransmittance));
    if (!any(open)) break;
    const uint32_t end = begin + kBatch < size ? begin + kBatch : size;
    uint32_t next = used;
    for (uint32_t e = begin; e < end; ++e) {
      const uint32_t local = task.sorted[e];
      const RasterSplat& splat = task.local[local];
      const SplatSample<F16> sample = splat_sample(splat.constants, place.px, place.py);
      Fragment& f = slots[next + 1];
      f.alpha = sample.alpha;
      f.z = select(sample.counts, sample.z, F16(kFarAway));
      f.splat = &splat;
      f.id = splat.id;
      seen[next] = local;
      fragments += static_cast<uint32_t>(__builtin_popcount(bits(sample.counts)));
      next += any(sample.counts & open) ? 1 : 0;
    }
    vectors += end - begin;
    while (used < next) settle(slots, ++used);
  }
  ForwardBlock<F, kDistortion> out;
  if (kDistortion && size > 0) out.pivot = F16(1.f / task.sorted_z[0]);
  for (uint32_t i = 1; i <= used; ++i) out.add(slots[i]);

  task.list_size[block] = used;
  task.fragments[0] += fragments;
  task.fragments[1] += vectors;
  const F16 behind = F16(1.f) - out.alpha;
  for (int c = 0; c < F; ++c)
    store(block_pixels(task, c, block), c < 3 ? out.features[c] + behind * F16(view.background[c]) : out.features[c]);
  store(block_pixels(task, F, block), out.zdepth);
  store(block_pixels(task, F + 1, block), out.alpha);
  store(block_pixels(task, F + 2, block), out.median_z);
  float* kept = task.kept + static_cast<size_t>(block) * static_cast<size_t>(view.kept_channels()) * kLanes;
  store(kept, out.median_z);
  if constexpr (kDistortion) {
    const float k = distortion_scale(view.near_z, view.far_z);
    store(block_pixels(task, F + 3, block), F16(k * k) * max(F16(0.f), out.alpha * out.q2 - out.q1 * out.q1));
    store(kept + kLanes, out.alpha);
    store(kept + 2 * kLanes, out.q1);
    store(kept + 3 * kLanes, out.q2);
    store(kept + 4 * kLanes, out.pivot);
  }
}

template <int F, bool kDistortion>
void forward_blocks(const PassView& view, const TileTask& task) {
  for (int block = 0; block < kBlocks; ++block) forward_block<F, kDistortion>(view, task, block);
}

inline void write_images(const PassView& view, const TileTask& task, const TileImages& images) {
  const PlacedTile tile = placed(view, task);
  const int f = view.features;
  for (int c = 0; c < f; ++c) write_plane(tile, task, c, images.features[c]);
  write_plane(tile, task, f, images.zdepth);
  write_plane(tile, task, f + 1, images.alpha);
  write_plane(tile, task, f + 2, images.median_z);
  if (view.distortion) write_plane(tile, task, f + 3, images.distortion);
}

inline void forward_tile(const PassView& view, const TileTask& task, const TileImages& images) {
  build_lists(task);
  if (view.features == 3) {
    view.distortion ? forward_blocks<3, true>(view, task) : forward_blocks<3, false>(view, task);
  } else if (view.features == 6) {
    view.distortion ? forward_blocks<6, true>(view, task) : forward_blocks<6, false>(view, task);
  } else {
    view.distortion ? forward_blocks<12, true>(view, task) : forward_blocks<12, false>(view, task);
  }
  write_images(view, task, images);
}

}  // namespace vitrine::VITRINE_SIMD
