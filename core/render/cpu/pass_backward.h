// Backward pass of a tile, front to back like the forward pass: "behind = total - in front" (README 7), so that nothing is
// stored per fragment. What lies in front of a fragment is settled pair by pair as well, when it becomes final.

namespace vitrine::VITRINE_SIMD {

struct alignas(64) PendingGradient : PendingFragment {
  SplatSample<F16> sample;
  F16 value;       // V: what a unit of its weight adds to the loss
  F16 front;       // sum of w V in front of it
  uint32_t local;  // index within the tile: where its record is

  VITRINE_INLINE F16 contribution() const { return blend_weight(alpha, transmittance) * value; }
};

template <int F>
struct BlockGradients {
  F16 features[F];
  F16 zdepth, weight, median_z, spread;       // weight: of alpha and of the background; spread: of distortion, times k^2
  alignas(64) float by_lane[kLanes][kLanes];  // row = pixel: feature gradients, then 1 (weight) and the error image
  F16 total;                                  // sum of w V over all fragments
  F16 kept_median;
  DistortionSums<F16> sums;
  F16 pivot;
};
inline constexpr int kWeightColumn = 12, kErrorColumn = 13;

// A block of an image plane; zero outside the image and for a plane that is not given.
inline F16 load_block(const PassView& view, const float* plane, int x, int y) {
  if (plane == nullptr) return F16(0.f);
  const size_t width = static_cast<size_t>(view.width);
  if (x + kBlockSide <= view.width && y + kBlockSide <= view.height)
    return load_rows(plane + static_cast<size_t>(y) * width + x, width);
  alignas(64) float lanes[kLanes];
  for (int lane = 0; lane < kLanes; ++lane) {
    const int px = x + lane % kBlockSide, py = y + lane / kBlockSide;
    const bool inside = px < view.width && py < view.height;
    lanes[lane] = inside ? plane[static_cast<size_t>(py) * width + px] : 0.f;
  }
  return load(lanes);
}

template <int F, bool kDistortion>
void load_gradients(const PassView& view, const TileTask& task, const TileGradients& g, int block, BlockGradients<F>& out) {
  const int x = task.x0 + kBlockSide * (block % kBlockSide), y = task.y0 + kBlockSide * (block / kBlockSide);
  const float* kept = task.kept + static_cast<size_t>(block) * static_cast<size_t>(view.kept_channels()) * kLanes;
  out.total = F16(0.f);
  out.weight = load_block(view, g.alpha, x, y);
  F16 columns[kLanes];
  for (int c = 0; c < F; ++c) {
    columns[c] = out.features[c] = load_block(view, g.planes[c], x, y);
    if (c < 3) out.weight -= F16(view.background[c]) * out.features[c];
    out.total += out.features[c] * load(kept + c * kLanes);
  }
  columns[kWeightColumn] = F16(1.f);
  columns[kErrorColumn] = load_block(view, g.error, x, y);
  for (int c = 0; c < kLanes; c += 4) {
    F16 pixels[4];
    columns_of(columns[c], columns[c + 1], columns[c + 2], columns[c + 3], pixels);
    for (int j = 0; j < 4; ++j) store_rows(out.by_lane[j] + c, 4 * kLanes, pixels[j]);
  }
  out.zdepth = load_block(view, g.zdepth, x, y);
  out.median_z = load_block(view, g.median_z, x, y);
  out.total += out.zdepth * load(kept + F * kLanes) + out.weight * load(kept + (F + 1) * kLanes);
  out.kept_median = load(kept + (F + 2) * kLanes);
  if constexpr (kDistortion) {
    const float k = distortion_scale(view.near_z, view.far_z);
    out.spread = F16(k * k) * load_block(view, g.distortion, x, y);
    out.sums.a = load(kept + (F + 1) * kLanes);
    out.sums.q1 = load(kept + (F + 3) * kLanes);
    out.sums.q2 = load(kept + (F + 4) * kLanes);
    out.pivot = load(kept + (F + 5) * kLanes);
    out.total += F16(2.f) * out.spread * out.sums.value();
  }
}

template <int F, bool kDistortion>
struct BackwardBlock {
  const BlockGradients<F>& g;
  float* records;
  float x_origin, y_origin;  // of the block, relative to the tile
  F16 row_y;                 // pixel centre's row relative to the tile
  F16 transmittance, front;  // of all final fragments

  VITRINE_INLINE F16 value_of(const PendingGradient& p) const {
    F16 value = g.weight + p.z * g.zdepth;
    for (int c = 0; c < F; ++c) value += F16(p.splat->features[c]) * g.features[c];
    if constexpr (kDistortion) value += g.spread * g.sums.weight_slope(reciprocal(p.z) - g.pivot);
    return value;
  }

  VITRINE_INLINE void finish(const PendingGradient& p, const F16& contribution) {
    const F16 w = blend_weight(p.alpha, p.transmittance);
    const F16 behind = g.total - p.front - contribution;
    const F16 grad_alpha = blend_vjp(p.transmittance, p.value, behind, reciprocal(p.transparency));
    const M16 is_median = (p.transmittance > F16(float(kMedianTransmittance))) & (p.alpha > F16(0.f)) & (p.z == g.kept_median);
    F16 grad_z = w * g.zdepth + select(is_median, g.median_z, F16(0.f));
    if constexpr (kDistortion) {
      const F16 inv_z = reciprocal(p.z);
      grad_z += g.spread * g.sums.depth_slope(w, inv_z - g.pivot, inv_z);
    }
    add_to_record(splat_sample_vjp(p.sample, grad_alpha, grad_z), w, records + static_cast<size_t>(p.local) * kRecordFloats);
    front += contribution;
    transmittance *= p.transparency;
  }

  // Sums over the sixteen pixels. Features: broadcasting each pixel's weight against its row of gradients needs no shuffles.
  // Moments: columns first, then rows, four quantities at a time.
  VITRINE_INLINE void add_to_record(const SampleGrad<F16>& s, const F16& w, float* record) const {
    alignas(64) float weight[kLanes];
    store(weight, w);
    F16 sum[4];
    for (int lane = 0; lane < kLanes; lane += 4)
      for (int k = 0; k < 4; ++k) sum[k] += F16(weight[lane + k]) * load(g.by_lane[lane + k]);
    store(record, load(record) + ((sum[0] + sum[1]) + (sum[2] + sum[3])));

    F16 c[4], o[4];
    columns_of(s.num_u, s.num_v, s.den, s.disc, c);
    columns_of(s.weight, s.z0, F16(0.f), F16(0.f), o);
    const F16 all = (c[0] + c[1]) + (c[2] + c[3]);
    const F16 by_x = all * F16(x_origin + 0.5f) + (c[1] + F16(2.f) * c[2] + F16(3.f) * c[3]);
    const F16 sums = sum_rows(all, by_x, all * row_y, (o[0] + o[1]) + (o[2] + o[3]));
    store(record + kLanes, load(record + kLanes) + sums);
  }
};

template <int F, bool kDistortion>
void backward_block(const PassView& view, const TileTask& task, const TileGradients& gradients, int block) {
  const uint32_t size = task.list_offset[block + 1] - task.list_offset[block];
  if (size == 0) return;
  const ListEntry* list = task.lists + task.list_offset[block];
  BlockGradients<F> g;
  load_gradients<F, kDistortion>(view, task, gradients, block, g);
  const BlockPlace place = block_place(view, task, block);
  BackwardBlock<F, kDistortion> out{g,
                                    gradients.records,
                                    float(kBlockSide * (block % kBlockSide)),
                                    float(kBlockSide * (block / kBlockSide)),
                                    place.py - F16(float(task.y0)),
                                    place.inside,
                                    F16(0.f)};
  PendingSet<PendingGradient> pending(task.slots, task.pending, size);
  // Makes pending[i] final: the others either lie in front of it, and are as good as final there, or behind it.
  const auto finish = [&](uint32_t i) {
    PendingGradient& p = pending[i];
    const F16 contribution = p.contribution();
    for (uint32_t j = 0; j < pending.size; ++j) {
      if (j == i) continue;
      PendingGradient& n = pending[j];
      const M16 p_first = in_front(p, n);
      p.front += select(p_first, F16(0.f), n.contribution());
      n.front += select(p_first, contribution, F16(0.f));
    }
    out.finish(p, contribution);
    pending.remove(i);
  };
  for (uint32_t e = 0; e < size; ++e) {
    const ListEntry& entry = list[e];
    for (uint32_t i = 0; i < pending.size;) {
      if (pending[i].z_max < entry.z_min)
        finish(i);
      else
        ++i;
    }
    if (!any(out.transmittance >= F16(float(kMinTransmittance)))) break;
    const RasterSplat& splat = task.local[entry.local];
    PendingGradient& fragment = pending.free_slot();
    fragment.sample = splat_sample(splat.constants, place.px, place.py);
    if (!any(fragment.sample.counts)) continue;
    fragment.alpha = fragment.sample.alpha;
    fragment.transparency = F16(1.f) - fragment.sample.alpha;
    fragment.transmittance = out.transmittance;
    fragment.z = fragment.sample.z;
    fragment.z_below = next_below(fragment.sample.z);
    fragment.splat = &splat;
    fragment.z_max = entry.z_max;
    fragment.id = splat.id;
    fragment.local = entry.local;
    fragment.front = out.front;
    fragment.value = out.value_of(fragment);
    for (uint32_t i = 0; i < pending.size; ++i) settle_pair(pending[i], fragment);
    ++pending.size;
  }
  while (pending.size > 0) finish(pending.size - 1);
}

template <int F, bool kDistortion>
void backward_blocks(const PassView& view, const TileTask& task, const TileGradients& gradients) {
  for (int block = 0; block < kBlocks; ++block) backward_block<F, kDistortion>(view, task, gradients, block);
}

// Moments were taken around the tile's corner; the surfel wants them around its own centre.
inline void centre_records(const TileTask& task, const TileGradients& gradients) {
  for (uint32_t i = 0; i < task.count; ++i) {
    const ScreenMap<float>& map = task.local[i].constants.map;
    const float x = float(task.x0) - map.cx, y = float(task.y0) - map.cy;
    float* moments = gradients.records + static_cast<size_t>(i) * kRecordFloats + kLanes;
    for (int k = 0; k < 4; ++k) {
      moments[4 + k] += x * moments[k];
      moments[8 + k] += y * moments[k];
    }
  }
}

inline void backward_tile(const PassView& view, const TileTask& task, const TileGradients& gradients) {
  __builtin_memset(gradients.records, 0, sizeof(float) * kRecordFloats * task.count);
  for (uint32_t i = 0; i < task.count; ++i) {
    if (i + kPrefetchAhead < task.count) {
      const uint32_t ahead = task.instances[i + kPrefetchAhead];
      __builtin_prefetch(task.splats + ahead);
      __builtin_prefetch(reinterpret_cast<const char*>(task.splats + ahead) + 64);
    }
    __builtin_memcpy(task.local + i, task.splats + task.instances[i], sizeof(RasterSplat));
  }
  if (view.features == 3) {
    view.distortion ? backward_blocks<3, true>(view, task, gradients) : backward_blocks<3, false>(view, task, gradients);
  } else if (view.features == 6) {
    view.distortion ? backward_blocks<6, true>(view, task, gradients) : backward_blocks<6, false>(view, task, gradients);
  } else {
    view.distortion ? backward_blocks<12, true>(view, task, gradients) : backward_blocks<12, false>(view, task, gradients);
  }
  centre_records(task, gradients);
}

}  // namespace vitrine::VITRINE_SIMD
