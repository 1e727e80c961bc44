// SIMD projection of sixteen surfels: raw values to screen records and bounds, and the sums of the records back to raw
// gradients (README 1, 4, 8). The formulas are in kernels/; this file loads, computes bounds and adds.

namespace vitrine::VITRINE_SIMD {

struct LaneValues {  // raw values of sixteen surfels
  SurfelGeometry<F16> geometry;
  F16 opacity;
  F16 sh[3 * kMaxShCoefficients];
  F16 material[kMaterialWidth];
};

inline F16 sigmoid_of(F16 x) { return F16(1.f) / (F16(1.f) + exp(-x)); }

inline int sh_rest_columns(const PassView& view) { return 3 * (static_cast<int>(sh_coefficient_count(view.sh_degree)) - 1); }

// rows: the surfels, [kLanes].
inline LaneValues load_values(const LayerPointers& layer, const PassView& view, const uint32_t* rows) {
  LaneValues s;
  F16 v[4];
  load_columns(layer.mean, rows, 3, 3, v);
  s.geometry.mean = {v[0], v[1], v[2]};
  load_columns(layer.rotation, rows, 4, 4, v);
  s.geometry.rotation = {v[0], v[1], v[2], v[3]};
  load_columns(layer.log_scale, rows, 2, 2, v);
  s.geometry.log_su = v[0];
  s.geometry.log_sv = v[1];
  load_columns(layer.opacity, rows, 1, 1, &s.opacity);
  load_columns(layer.sh_dc, rows, 3, 3, s.sh);
  load_columns(layer.sh_rest, rows, static_cast<size_t>(layer.sh_rest_width), sh_rest_columns(view), s.sh + 3);
  if (view.features == static_cast<int>(kMaxFeatures)) {
    load_columns(layer.material[0], rows, 3, 3, s.material);
    for (int m = 1; m < 4; ++m) load_columns(layer.material[m], rows, 1, 1, s.material + 2 + m);
  }
  return s;
}

inline Camera<F16> lane_camera(const PassView& v) {
  const float* r = v.rotation;
  return {F16(v.fx),
          F16(v.fy),
          F16(v.cx),
          F16(v.cy),
          Mat3<F16>{{F16(r[0]), F16(r[1]), F16(r[2])}, {F16(r[3]), F16(r[4]), F16(r[5])}, {F16(r[6]), F16(r[7]), F16(r[8])}},
          {F16(v.translation[0]), F16(v.translation[1]), F16(v.translation[2])},
          {F16(v.eye[0]), F16(v.eye[1]), F16(v.eye[2])}};
}

template <int N>
struct LaneTable {  // N vectors, accessed lane by lane
  alignas(64) float rows[N][kLanes];
  void set(int row, F16 v) { store(rows[row], v); }
};

inline uint32_t project_surfels(const LayerPointers& layer, const PassView& view, uint32_t first, uint32_t count,
                                RasterSplat* splats, SplatBounds* bounds) {
  const Camera<F16> camera = lane_camera(view);
  const bool low_pass = view.low_pass < float(kNoLowPass);
  uint32_t written = 0;
  for (uint32_t begin = 0; begin < count; begin += kLanes) {
    uint32_t rows[kLanes];
    for (uint32_t i = 0; i < kLanes; ++i) rows[i] = first + (begin + i < count ? begin + i : count - 1);
    const LaneValues s = load_values(layer, view, rows);
    const Projection<F16> p = project(s.geometry, camera);
    const F16 opacity = sigmoid_of(s.opacity), near_z(view.near_z);
    const EllipseBounds<F16, M16> b = ellipse_bounds(p, opacity, near_z, low_pass);
    const uint32_t left = count - begin;
    uint32_t visible = bits(is_visible(p, opacity, near_z)) & (left >= kLanes ? 0xffffu : (1u << left) - 1u);
    if (visible == 0) continue;
    const ShColour<F16> colour = sh_colour(view.sh_degree, s.geometry.mean, camera.eye, s.sh);

    LaneTable<24> splat;
    const F16 constants[12] = {p.map.cx,  p.map.cy, p.map.z0, p.map.m00, p.map.m01,         p.map.m10,
                               p.map.m11, p.map.h0, p.map.h1, opacity,   near_z / p.map.z0, F16(view.low_pass)};
    for (int k = 0; k < 12; ++k) splat.set(k, constants[k]);
    for (int c = 0; c < 3; ++c) {
      splat.set(12 + static_cast<int>(kColourAt) + c, colour.value[static_cast<size_t>(c)]);
      splat.set(12 + static_cast<int>(kNormalAt) + c, p.normal[static_cast<size_t>(c)]);
    }
    for (int c = 0; c < static_cast<int>(kMaterialWidth); ++c) {
      splat.set(12 + static_cast<int>(kMaterialAt) + c,
                view.features == static_cast<int>(kMaxFeatures) ? sigmoid_of(s.material[c]) : F16(0.f));
    }
    LaneTable<19> bound;
    const F16 limits[19] = {b.ex,     b.ey,  b.inv_yy, b.inv_xx, b.shear_xy, b.shear_yx, b.disc_r2, b.z_low, b.z_high, b.half_x,
                            b.half_y, b.cut, p.Au,     p.Av,     p.Bu,       p.Bv,       p.a_u.z,   p.a_v.z, F16(0.f)};
    for (int k = 0; k < 19; ++k) bound.set(k, limits[k]);
    const uint32_t ellipses = bits(b.is_ellipse);
    for (; visible != 0; visible &= visible - 1) {
      const int lane = __builtin_ctz(visible);
      const auto value = [&](int row) { return splat.rows[row][lane]; };
      const auto limit = [&](int row) { return bound.rows[row][lane]; };
      SplatBounds& to = bounds[written];
      to.cx = value(0);
      to.cy = value(1);
      to.z0 = value(2);
      to.h0 = value(7);
      to.h1 = value(8);
      to.ex = limit(0);
      to.ey = limit(1);
      to.disc_r2 = limit(6);
      to.z_low = limit(7);
      to.z_high = limit(8);
      ScreenBox<float> box;
      if (ellipses >> lane & 1u) {
        to.inv_yy = limit(2);
        to.inv_xx = limit(3);
        to.shear_xy = limit(4);
        to.shear_yx = limit(5);
        box = {to.ex - limit(9), to.ex + limit(9), to.ey - limit(10), to.ey + limit(10)};
      } else {
        to.ex = to.ey = to.inv_yy = to.inv_xx = to.shear_xy = to.shear_yx = 0.f;  // every block of the box is hit
        const ScreenColumns<float> columns{limit(12), limit(13), limit(14), limit(15), limit(16),
                                           limit(17), value(0),  value(1),  value(2)};
        box = clipped_box(columns, __builtin_sqrtf(limit(11)), view.near_z);
      }
      if (low_pass) {
        const float r = __builtin_sqrtf(to.disc_r2);
        box.add(to.cx - r, to.cy - r);
        box.add(to.cx + r, to.cy + r);
      }
      pixel_range(box.x_lo, box.x_hi, view.width, to.x_first, to.x_last);
      pixel_range(box.y_lo, box.y_hi, view.height, to.y_first, to.y_last);
      if (to.x_first > to.x_last || to.y_first > to.y_last) continue;
      float* record = reinterpret_cast<float*>(splats + written);
      for (int k = 0; k < 24; ++k) record[k] = value(k);
      splats[written].id = first + begin + static_cast<uint32_t>(lane);
      ++written;
    }
  }
  return written;
}

// The records of a surfel lie in as many memory locations as it has tiles.
inline constexpr uint32_t kRecordsAhead = 12;
inline void prefetch_records(const GradientTask& task, uint32_t i) {
  const uint32_t rank = task.rank[task.batch[i]];
  for (uint32_t r = task.record_begin[rank]; r < task.record_begin[rank + 1]; ++r) {
    const float* record = task.records + static_cast<size_t>(task.record_index[r]) * kRecordFloats;
    __builtin_prefetch(record);
    __builtin_prefetch(record + kLanes);
  }
}

// dL/d(raw values) of up to sixteen surfels from the records of their tiles, added in tile order.
inline void surfel_gradients(const PassView& view, const GradientTask& task) {
  alignas(64) float sums[kLanes][kRecordFloats];
  alignas(64) uint32_t ids[kLanes];
  for (uint32_t i = 0; i < kLanes; ++i) {
    const uint32_t splat = task.batch[i < task.count ? i : task.count - 1], rank = task.rank[splat];
    if (i + kRecordsAhead < task.available) prefetch_records(task, i + kRecordsAhead);
    F16 low(0.f), high(0.f);
    for (uint32_t r = task.record_begin[rank]; r < task.record_begin[rank + 1]; ++r) {
      const float* record = task.records + static_cast<size_t>(task.record_index[r]) * kRecordFloats;
      low += load(record);
      high += load(record + kLanes);
    }
    store(sums[i], column_count(view.features) == kLanes ? low : fold_halves(low));
    store(sums[i] + kLanes, high);
    ids[i] = task.splats[splat].id;
  }
  uint32_t lanes[kLanes];
  for (uint32_t i = 0; i < kLanes; ++i) lanes[i] = i;
  F16 sum[kRecordFloats];
  load_columns(sums[0], lanes, kRecordFloats, kRecordFloats, sum);
  const Camera<F16> camera = lane_camera(view);
  const LaneValues s = load_values(*task.values, view, ids);
  const Projection<F16> p = project(s.geometry, camera);
  const F16 opacity = sigmoid_of(s.opacity);
  const ShColour<F16> colour = sh_colour(view.sh_degree, s.geometry.mean, camera.eye, s.sh);
  SplatMoments<F16> m;
  m.num_u = sum[16], m.num_v = sum[17], m.den = sum[18];
  m.num_u_x = sum[20], m.num_v_x = sum[21], m.den_x = sum[22], m.disc_x = sum[23];
  m.num_u_y = sum[24], m.num_v_y = sum[25], m.den_y = sum[26], m.disc_y = sum[27];
  m.weight = sum[28] + sum[30], m.z0 = sum[29] + sum[31];
  const SplatGrad<F16> splat = splat_grad(m, p.map, opacity);
  const bool normals = view.features >= static_cast<int>(kNormalAt + 3);
  const F16 zero(0.f);
  const Vec3<F16> grad_normal = normals ? Vec3<F16>{sum[3], sum[4], sum[5]} : Vec3<F16>{zero, zero, zero};
  const ProjectionGrad<F16> g = project_vjp(s.geometry, camera, p, splat.map, grad_normal);
  F16 grad_sh[3 * kMaxShCoefficients];
  const Vec3<F16> grad_direction = sh_colour_vjp(view.sh_degree, colour, s.sh, Vec3<F16>{sum[0], sum[1], sum[2]}, grad_sh);
  const Vec3<F16> grad_mean = g.surfel.mean + grad_direction;

  const LayerPointers& out = *task.grad;
  const auto add = [&](float* to, int width, int columns, const F16* v) {
    add_columns(to, ids, task.count, static_cast<size_t>(width), columns, v);
  };
  const auto& q = g.surfel.rotation;
  const F16 mean[3] = {grad_mean.x, grad_mean.y, grad_mean.z}, rotation[4] = {q.w, q.x, q.y, q.z};
  const F16 log_scale[2] = {g.surfel.log_su, g.surfel.log_sv};
  add(out.mean, 3, 3, mean);
  add(out.rotation, 4, 4, rotation);
  add(out.log_scale, 2, 2, log_scale);
  add(out.opacity, 1, 1, &splat.raw_opacity);
  add(out.sh_dc, 3, 3, grad_sh);
  add(out.sh_rest, out.sh_rest_width, sh_rest_columns(view), grad_sh + 3);
  if (view.features == static_cast<int>(kMaxFeatures)) {
    F16 material[kMaterialWidth];
    for (int c = 0; c < static_cast<int>(kMaterialWidth); ++c) {
      const F16 a = sigmoid_of(s.material[c]);
      material[c] = sum[static_cast<int>(kMaterialAt) + c] * a * (F16(1.f) - a);
    }
    add(out.material[0], 3, 3, material);
    for (int m = 1; m < 4; ++m) add(out.material[m], 1, 1, material + 2 + m);
  }
  if (task.screen_gradient == nullptr) return;
  const F16 gx = g.screen_x * F16(0.5f * float(view.width)), gy = g.screen_y * F16(0.5f * float(view.height));
  const F16 norm = sqrt(gx * gx + gy * gy);
  add(task.screen_gradient, 1, 1, &norm);
  add(task.weight, 1, 1, sum + weight_column(view.features));
  add(task.error, 1, 1, sum + error_column(view.features));
}

inline const PassTable& pass_table(const char* tag) {
  static const PassTable table{tag,          sizeof(Fragment), sizeof(GradientFragment), project_surfels,
                               forward_tile, backward_tile,    surfel_gradients};
  return table;
}

}  // namespace vitrine::VITRINE_SIMD
