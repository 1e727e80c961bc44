// Forward pass of a tile: blocks of 4x4 pixels, exact depth order per pixel without sorting pixels (README 6).
//
// Only the transmittance in front of a fragment depends on the order; sums do not. Surfels come in ascending z_min. A fragment
// waits ("pending") while a later surfel could still lie in front of it in some pixel; when a new one arrives, each pending pair
// settles lane by lane who dims whom. Once z_max of the pending one is below the z_min of all that follows, it is final.

namespace vitrine::VITRINE_SIMD {

struct BlockPlace {
  F16 px, py;
  F16 inside;  // 1 in the image, 0 outside
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
  p.inside = select((p.px < F16(float(view.width))) & (p.py < F16(float(view.height))), F16(1.f), F16(0.f));
  return p;
}

struct alignas(64) PendingFragment {
  F16 alpha, transparency;  // transparency = 1 - alpha
  F16 transmittance;        // of what is known to lie in front
  F16 z, z_below;           // z_below: the float before z, so that z_p <= z_below means z_p < z
  const RasterSplat* splat;
  float z_max;
  uint32_t id;
};

// Lanes in which `a` lies in front of `b`: by (z, id).
VITRINE_INLINE M16 in_front(const PendingFragment& a, const PendingFragment& b) {
  const F16* limit = a.id < b.id ? &b.z : &b.z_below;
  return a.z <= *limit;
}

// A new fragment meets a pending one: each dims the other where it lies in front of it.
VITRINE_INLINE void settle_pair(PendingFragment& a, PendingFragment& b) {
  const M16 a_first = in_front(a, b);
  a.transmittance = select(a_first, a.transmittance, a.transmittance * b.transparency);
  b.transmittance = select(a_first, b.transmittance * a.transparency, b.transmittance);
}

// The pending fragments of a block: slots of type Slot in use, and the free ones behind them.
template <class Slot>
struct PendingSet {
  Slot* slots;
  uint32_t* order;  // [capacity]: slots in use, then free slots
  uint32_t size = 0;

  PendingSet(unsigned char* memory, uint32_t* indices, uint32_t capacity)
      : slots(reinterpret_cast<Slot*>(memory)), order(indices) {
    for (uint32_t i = 0; i < capacity; ++i) order[i] = i;
  }
  Slot& operator[](uint32_t i) { return slots[order[i]]; }
  Slot& free_slot() { return slots[order[size]]; }
  void remove(uint32_t i) {
    const uint32_t freed = order[i];
    order[i] = order[--size];
    order[size] = freed;
  }
};

template <int F, bool kDistortion>
struct ForwardBlock {
  F16 features[F];
  F16 zdepth, alpha, median_z, q1, q2, pivot;
  F16 transmittance;  // of all final fragments

  VITRINE_INLINE void finish(const PendingFragment& p) {
    const F16 w = blend_weight(p.alpha, p.transmittance);
    for (int c = 0; c < F; ++c) features[c] += w * F16(p.splat->features[c]);
    zdepth += w * p.z;
    alpha += w;
    median_z = select((p.transmittance > F16(float(kMedianTransmittance))) & (p.alpha > F16(0.f)), max(median_z, p.z), median_z);
    if constexpr (kDistortion) {
      const F16 q = reciprocal(p.z) - pivot, wq = w * q;
      q1 += wq;
      q2 += wq * q;
    }
    transmittance *= p.transparency;
  }
};

template <int F, bool kDistortion>
void forward_block(const PassView& view, const TileTask& task, int block) {
  const BlockPlace place = block_place(view, task, block);
  ForwardBlock<F, kDistortion> out;
  out.transmittance = place.inside;
  const ListEntry* list = task.lists + task.list_offset[block];
  const uint32_t size = task.list_size[block];
  PendingSet<PendingFragment> pending(task.slots, task.pending, size);
  if (kDistortion && size > 0) out.pivot = F16(1.f / list[0].z_min);
  uint32_t fragments = 0, vectors = 0;
  for (uint32_t e = 0; e < size; ++e) {
    const ListEntry& entry = list[e];
    for (uint32_t i = 0; i < pending.size;) {
      if (pending[i].z_max < entry.z_min) {
        out.finish(pending[i]);
        pending.remove(i);
      } else {
        ++i;
      }
    }
    // What follows lies behind everything final, and could only dim pending fragments in pixels that are full already.
    if (!any(out.transmittance >= F16(float(kMinTransmittance)))) break;
    const RasterSplat& splat = task.local[entry.local];
    const SplatSample<F16> sample = splat_sample(splat.constants, place.px, place.py);
    const uint32_t hits = bits(sample.counts);
    ++vectors;
    fragments += static_cast<uint32_t>(__builtin_popcount(hits));
    if (hits == 0) continue;
    PendingFragment& fragment = pending.free_slot();
    fragment.alpha = sample.alpha;
    fragment.transparency = F16(1.f) - sample.alpha;
    fragment.transmittance = out.transmittance;
    fragment.z = sample.z;
    fragment.z_below = next_below(sample.z);
    fragment.splat = &splat;
    fragment.z_max = entry.z_max;
    fragment.id = splat.id;
    for (uint32_t i = 0; i < pending.size; ++i) settle_pair(pending[i], fragment);
    ++pending.size;
  }
  for (uint32_t i = 0; i < pending.size; ++i) out.finish(pending[i]);

  task.fragments[0] += fragments;
  task.fragments[1] += vectors;
  float* kept = task.kept + static_cast<size_t>(block) * static_cast<size_t>(view.kept_channels()) * kLanes;
  for (int c = 0; c < F; ++c) store(kept + c * kLanes, out.features[c]);
  store(kept + F * kLanes, out.zdepth);
  store(kept + (F + 1) * kLanes, out.alpha);
  store(kept + (F + 2) * kLanes, out.median_z);
  if constexpr (kDistortion) {
    store(kept + (F + 3) * kLanes, out.q1);
    store(kept + (F + 4) * kLanes, out.q2);
    store(kept + (F + 5) * kLanes, out.pivot);
  }
}

template <int F, bool kDistortion>
void forward_blocks(const PassView& view, const TileTask& task) {
  for (int block = 0; block < kBlocks; ++block) forward_block<F, kDistortion>(view, task, block);
}

inline void forward_tile(const PassView& view, const TileTask& task) {
  build_lists(task);
  if (view.features == 3) return view.distortion ? forward_blocks<3, true>(view, task) : forward_blocks<3, false>(view, task);
  if (view.features == 6) return view.distortion ? forward_blocks<6, true>(view, task) : forward_blocks<6, false>(view, task);
  return view.distortion ? forward_blocks<12, true>(view, task) : forward_blocks<12, false>(view, task);
}

}  // namespace vitrine::VITRINE_SIMD
