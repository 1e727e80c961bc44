// Backward pass of a tile: "behind = total - in front" (README 7). Three loops over the surfels of a block: resolve the depth
// order as in the forward pass; sum the fragments in front of each fragment, in the same pairs; then compute the gradients.

namespace vitrine::VITRINE_SIMD {

struct alignas(64) GradientFragment : Fragment {
  F16 u, v, inv_den;
  F16 value;         // V: derivative of the loss by its weight
  F16 contribution;  // w V
  F16 front;         // sum of w V in front of it
  F16 sum;           // of w V up to this slot
  M16 on_plane, counts, free;
  uint32_t local;  // index within the tile, locates its record
};

// First half of a record: sums over pixels of w times the gradient of each feature, of w, of w times the error image. With up
// to six features they use eight floats, and the two halves of the vector are added.
constexpr int column_count(int features) { return features <= 6 ? 8 : 16; }
constexpr int weight_column(int features) { return features <= 6 ? 6 : 12; }
constexpr int error_column(int features) { return weight_column(features) + 1; }

template <int F>
struct BlockGradients {
  F16 features[F];
  F16 zdepth, weight, median_z, spread;  // weight: of alpha and of the background; spread: of distortion, times k^2
  alignas(64) float by_pixel[kLanes * column_count(F)];  // one row per pixel: feature gradients, then 1 (weight), error image
  F16 total;                                             // sum of w V over all fragments
  F16 kept_median;
  DistortionSums<F16> sums;
  F16 pivot;
};

inline void read_gradients(const PassView& view, const TileTask& task, const TileGradients& g) {
  const PlacedTile tile = placed(view, task);
  const int f = view.features;
  for (int c = 0; c < f; ++c) read_plane(tile, task, c, g.features[c]);
  read_plane(tile, task, f, g.zdepth);
  read_plane(tile, task, f + 1, g.alpha);
  read_plane(tile, task, f + 2, g.median_z);
  read_plane(tile, task, f + 3, g.distortion);
  read_plane(tile, task, f + 4, g.error);
}

template <int F, bool kDistortion>
void load_gradients(const PassView& view, const TileTask& task, int block, BlockGradients<F>& out) {
  const auto channel = [&](int c) { return load(block_pixels(task, c, block)); };
  out.weight = channel(F + 1);
  F16 columns[kLanes];
  for (int c = 0; c < F; ++c) {
    columns[c] = out.features[c] = channel(c);
    if (c < 3) out.weight -= F16(view.background[c]) * out.features[c];
  }
  columns[weight_column(F)] = F16(1.f);
  columns[error_column(F)] = channel(F + 4);
  for (int c = 0; c < column_count(F); c += 4) {
    F16 pixels[4];
    columns_of(columns[c], columns[c + 1], columns[c + 2], columns[c + 3], pixels);
    for (int j = 0; j < 4; ++j) store_rows(out.by_pixel + j * column_count(F) + c, kBlockSide * column_count(F), pixels[j]);
  }
  out.zdepth = channel(F);
  out.median_z = channel(F + 2);
  const float* kept = task.kept + static_cast<size_t>(block) * static_cast<size_t>(view.kept_channels()) * kLanes;
  out.kept_median = load(kept);
  if constexpr (kDistortion) {
    const float k = distortion_scale(view.near_z, view.far_z);
    out.spread = F16(k * k) * channel(F + 3);
    out.sums.a = load(kept + kLanes);
    out.sums.q1 = load(kept + 2 * kLanes);
    out.sums.q2 = load(kept + 3 * kLanes);
    out.pivot = load(kept + 4 * kLanes);
  }
}

template <int F, bool kDistortion>
struct BackwardBlock {
  const BlockGradients<F>& g;
  float* records;
  float x_origin, y_origin;  // of the block, relative to the tile
  F16 row_y;                 // row of the pixel centre relative to the tile

  VITRINE_INLINE F16 value_of(const Fragment& f) const {
    F16 value = g.weight + f.z * g.zdepth;
    for (int c = 0; c < F; ++c) value += F16(f.splat->features[c]) * g.features[c];
    if constexpr (kDistortion) value += g.spread * g.sums.weight_slope(reciprocal(f.z) - g.pivot);
    return value;
  }

  VITRINE_INLINE void add_gradient(const GradientFragment& f) const {
    const F16 w = blend_weight(f.alpha, f.transmittance);
    const F16 behind = g.total - f.front - f.contribution;
    const F16 grad_alpha = blend_vjp(f.transmittance, f.value, behind, reciprocal(F16(1.f) - f.alpha));
    const M16 is_median = (f.transmittance > F16(float(kMedianTransmittance))) & f.counts & (f.z == g.kept_median);
    F16 grad_z = w * g.zdepth + select(is_median, g.median_z, F16(0.f));
    if constexpr (kDistortion) {
      const F16 inv_z = reciprocal(f.z);
      grad_z += g.spread * g.sums.depth_slope(w, inv_z - g.pivot, inv_z);
    }
    SplatSample<F16> sample;
    sample.u = f.u;
    sample.v = f.v;
    sample.inv_den = f.inv_den;
    sample.rho3d = f.u * f.u + f.v * f.v;
    sample.alpha = f.alpha;
    sample.z = f.z;
    sample.on_plane = f.on_plane;
    sample.counts = f.counts;
    sample.free = f.free;
    add_to_record(splat_sample_vjp(sample, grad_alpha, grad_z), w, records + static_cast<size_t>(f.local) * kRecordFloats);
  }

  // Sums over the sixteen pixels. Features: broadcasting each pixel's weight against its row of gradients needs no shuffles.
  // Moments: columns first, then rows, four quantities at a time.
  VITRINE_INLINE void add_to_record(const SampleGrad<F16>& s, const F16& w, float* record) const {
    F16 sum[4];
    if constexpr (column_count(F) == kLanes) {
      alignas(64) float weight[kLanes];
      store(weight, w);
      for (int lane = 0; lane < kLanes; ++lane) sum[lane % 4] += F16(weight[lane]) * load(g.by_pixel + lane * kLanes);
    } else {
      for (int pair = 0; pair < kLanes / 2; ++pair) sum[pair % 4] += spread_pair(w, pair) * load(g.by_pixel + pair * kLanes);
    }
    store(record, load(record) + ((sum[0] + sum[1]) + (sum[2] + sum[3])));

    F16 c[4];
    columns_of(s.num_u, s.num_v, s.den, s.disc, c);
    const F16 all = (c[0] + c[1]) + (c[2] + c[3]);
    const F16 by_x = all * F16(x_origin + 0.5f) + (c[1] + F16(2.f) * c[2] + F16(3.f) * c[3]);
    const F16 sums = sum_rows(all, by_x, all * row_y, pair_columns(s.weight, s.z0));
    store(record + kLanes, load(record + kLanes) + sums);
  }
};

template <int F, bool kDistortion>
void backward_block(const PassView& view, const TileTask& task, const TileGradients& gradients, int block) {
  const uint32_t size = task.list_offset[block + 1] - task.list_offset[block];
  if (size == 0) return;
  const uint32_t* list = task.list + task.list_offset[block];
  const BlockPlace place = block_place(view, task, block);
  GradientFragment* slots = reinterpret_cast<GradientFragment*>(task.slots);
  for (uint32_t i = 0; i <= kStride; ++i) {
    slots[i].be_the_eye(place.inside);
    slots[i].contribution = slots[i].sum = F16(0.f);
  }
  slots += kStride;
  for (uint32_t i = 1; i <= size; ++i) {
    GradientFragment& f = slots[i];
    f.local = list[i - 1];
    f.splat = task.local + f.local;
    const SplatSample<F16> sample = splat_sample(f.splat->constants, place.px, place.py);
    f.alpha = sample.alpha;
    f.z = select(sample.counts, sample.z, F16(kFarAway));
    f.id = f.splat->id;
    f.u = sample.u;
    f.v = sample.v;
    f.inv_den = sample.inv_den;
    f.on_plane = sample.on_plane;
    f.counts = sample.counts;
    f.free = sample.free;
  }
  for (uint32_t i = 1; i <= size; ++i) settle(slots, i);

  BlockGradients<F> g;
  load_gradients<F, kDistortion>(view, task, block, g);
  const BackwardBlock<F, kDistortion> out{g, gradients.records, float(kBlockSide * (block % kBlockSide)),
                                          float(kBlockSide * (block / kBlockSide)), place.py - F16(float(task.y0))};
  for (uint32_t i = 1; i <= size; ++i) {
    GradientFragment& f = slots[i];
    f.value = out.value_of(f);
    f.contribution = blend_weight(f.alpha, f.transmittance) * f.value;
    f.sum = slots[i - 1].sum + f.contribution;
    GradientFragment* older = slots + f.compared_from;
    F16 front = older[-1].sum;
    const DepthOrder order(f);
    for (; older != &f; older += kStride) {
      for (uint32_t j = 0; j < kStride; ++j) {
        const M16 first = order.before(older[j]);
        front = add_where(~first, front, older[j].contribution);
        older[j].front = add_where(first, older[j].front, f.contribution);
      }
    }
    f.front = front;
  }
  g.total = slots[size].sum;
  for (uint32_t i = 1; i <= size; ++i) out.add_gradient(slots[i]);
}

template <int F, bool kDistortion>
void backward_blocks(const PassView& view, const TileTask& task, const TileGradients& gradients) {
  for (int block = 0; block < kBlocks; ++block) backward_block<F, kDistortion>(view, task, gradients, block);
}

// Converts the moments from the tile's corner to the surfel's own centre.
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
  read_gradients(view, task, gradients);
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
