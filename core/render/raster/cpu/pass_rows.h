// Loads rows of a table of floats, one for each of sixteen surfels, as columns of sixteen lanes, and stores them back (README
// 6, 8). Four columns at a time: sixteen loads of four floats and a transposition are several times faster than gathering each
// column.

namespace vitrine::VITRINE_SIMD {

using namespace vitrine::cpu;

// Loads the first N of four floats; memory behind them is not accessed.
template <int N>
VITRINE_INLINE __m128 load_some(const float* p) {
  if constexpr (N == 1) return _mm_load_ss(p);
  if constexpr (N == 2) return _mm_loadl_pi(_mm_setzero_ps(), reinterpret_cast<const __m64*>(p));
  if constexpr (N == 3) return _mm_movelh_ps(load_some<2>(p), _mm_load_ss(p + 2));
  return _mm_loadu_ps(p);
}
template <int N>
VITRINE_INLINE void store_some(float* p, __m128 v) {
  if constexpr (N == 1) _mm_store_ss(p, v);
  if constexpr (N == 2 || N == 3) _mm_storel_pi(reinterpret_cast<__m64*>(p), v);
  if constexpr (N == 3) _mm_store_ss(p + 2, _mm_movehl_ps(v, v));
  if constexpr (N == 4) _mm_storeu_ps(p, v);
}

// columns_of() makes lane 4 r + k of each column from quarter r of argument k.
template <int N>
VITRINE_INLINE void load_four(const float* table, const uint32_t* rows, size_t width, F16* out) {
  const auto row = [&](int lane) { return load_some<N>(table + rows[lane] * width); };
  const auto every_fourth = [&](int k) { return from_quarters(row(k), row(k + 4), row(k + 8), row(k + 12)); };
  F16 columns[4];
  columns_of(every_fourth(0), every_fourth(1), every_fourth(2), every_fourth(3), columns);
  for (int c = 0; c < N; ++c) out[c] = columns[c];
}
template <int N>
VITRINE_INLINE void add_four(float* table, const uint32_t* rows, uint32_t count, size_t width, const F16* v) {
  F16 every_fourth[4];
  const F16 zero(0.f);
  columns_of(v[0], N > 1 ? v[1] : zero, N > 2 ? v[2] : zero, N > 3 ? v[3] : zero, every_fourth);
  alignas(64) float lanes[4 * kLanes];
  for (int k = 0; k < 4; ++k) store(lanes + k * kLanes, every_fourth[k]);
  for (uint32_t lane = 0; lane < count; ++lane) {
    float* to = table + rows[lane] * width;
    store_some<N>(to, _mm_add_ps(load_some<N>(to), _mm_load_ps(lanes + lane % 4 * kLanes + lane / 4 * 4)));
  }
}

// out[c], lane i = table[rows[i]][c] of the first `columns` of `width` columns. rows: [kLanes].
inline void load_columns(const float* table, const uint32_t* rows, size_t width, int columns, F16* out) {
  int c = 0;
  for (; c + 4 <= columns; c += 4) load_four<4>(table + c, rows, width, out + c);
  if (columns - c == 1) load_four<1>(table + c, rows, width, out + c);
  if (columns - c == 2) load_four<2>(table + c, rows, width, out + c);
  if (columns - c == 3) load_four<3>(table + c, rows, width, out + c);
}
// table[rows[i]][c] += v[c], lane i, for the first `count` lanes.
inline void add_columns(float* table, const uint32_t* rows, uint32_t count, size_t width, int columns, const F16* v) {
  int c = 0;
  for (; c + 4 <= columns; c += 4) add_four<4>(table + c, rows, count, width, v + c);
  if (columns - c == 1) add_four<1>(table + c, rows, count, width, v + c);
  if (columns - c == 2) add_four<2>(table + c, rows, count, width, v + c);
  if (columns - c == 3) add_four<3>(table + c, rows, count, width, v + c);
}

}  // namespace vitrine::VITRINE_SIMD
