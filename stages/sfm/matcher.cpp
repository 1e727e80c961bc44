#include "stages/sfm/matcher.h"

// GCC 12 warns about the deliberately undefined pass-through operand of its own AVX-512 headers (GCC PR 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

constexpr size_t kPanelColumns = 256;  // 32 KiB of bytes: half to two thirds of an L1 cache
constexpr size_t kRowTile = 6;         // 6 x 4 accumulators of 32 registers; row counts are padded to it
constexpr size_t kAvx2RowTile = 4;

size_t rounded_up(size_t n, size_t step) { return (n + step - 1) / step * step; }

// Lane-wise running best two of one row (or of 16 columns): values and the index of the best.
template <size_t Lanes>
struct alignas(64) TopTwo {
  int32_t best[Lanes], second[Lanes], index[Lanes];
};

// Output of both kernels. Rows keep one lane per column residue (mod Lanes) until the end; columns map to lanes directly.
template <size_t Lanes>
struct Tables {
  std::vector<TopTwo<Lanes>> rows;     // [padded rows]
  std::vector<TopTwo<Lanes>> columns;  // [padded columns / Lanes]
};

template <size_t Lanes>
void reset(std::vector<TopTwo<Lanes>>& tops, size_t n) {
  TopTwo<Lanes> empty;
  std::fill_n(empty.best, Lanes, -1);
  std::fill_n(empty.second, Lanes, -1);
  std::fill_n(empty.index, Lanes, -1);
  tops.assign(n, empty);
}

struct KernelDesc {
  size_t rows = 0, padded_rows = 0, columns = 0, padded_columns = 0;
  const void* row_data = nullptr;
  const void* panel_data = nullptr;
  const int32_t* offsets = nullptr;
};

#define VITRINE_VNNI __attribute__((target("avx512f,avx512bw,avx512vl,avx512vnni")))

VITRINE_VNNI inline void keep_top_two(__m512i value, __m512i index, __m512i& best, __m512i& second, __m512i& best_index) {
  const __mmask16 better = _mm512_cmpgt_epi32_mask(value, best);
  second = _mm512_max_epi32(second, _mm512_min_epi32(value, best));
  best = _mm512_max_epi32(best, value);
  best_index = _mm512_mask_mov_epi32(best_index, better, index);
}

// Tile of 6 rows x 4 vectors of 16 columns: 24 accumulators, one load per 6 products.
VITRINE_VNNI void run_vnni(const KernelDesc& d, Tables<16>& t) {
  const int8_t* rows = static_cast<const int8_t*>(d.row_data);
  const uint8_t* panels = static_cast<const uint8_t*>(d.panel_data);
  const __m512i lane = _mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0);
  for (size_t panel = 0; panel < d.padded_columns; panel += kPanelColumns) {
    const size_t panel_end = std::min(panel + kPanelColumns, d.padded_columns);
    for (size_t r0 = 0; r0 < d.padded_rows; r0 += kRowTile) {
      const int8_t* row = rows + r0 * kDescriptorBytes;
      for (size_t c0 = panel; c0 < panel_end; c0 += 64) {
        __m512i acc[kRowTile][4];
        for (size_t v = 0; v < 4; ++v) {
          const __m512i start = _mm512_loadu_si512(d.offsets + c0 + 16 * v);
          for (size_t r = 0; r < kRowTile; ++r) acc[r][v] = start;
        }
        const uint8_t* block = panels + c0 * kDescriptorBytes;
        for (size_t q = 0; q < kDescriptorBytes / 4; ++q) {
          const __m512i b0 = _mm512_loadu_si512(block + q * 64), b1 = _mm512_loadu_si512(block + 2048 + q * 64),
                        b2 = _mm512_loadu_si512(block + 4096 + q * 64), b3 = _mm512_loadu_si512(block + 6144 + q * 64);
          for (size_t r = 0; r < kRowTile; ++r) {
            int32_t quad;
            std::memcpy(&quad, row + r * kDescriptorBytes + 4 * q, 4);
            const __m512i a = _mm512_set1_epi32(quad);
            acc[r][0] = _mm512_dpbusd_epi32(acc[r][0], b0, a);
            acc[r][1] = _mm512_dpbusd_epi32(acc[r][1], b1, a);
            acc[r][2] = _mm512_dpbusd_epi32(acc[r][2], b2, a);
            acc[r][3] = _mm512_dpbusd_epi32(acc[r][3], b3, a);
          }
        }
        for (size_t v = 0; v < 4; ++v) {
          TopTwo<16>& column = t.columns[c0 / 16 + v];
          __m512i best = _mm512_load_si512(column.best), second = _mm512_load_si512(column.second),
                  index = _mm512_load_si512(column.index);
          for (size_t r = 0; r < kRowTile; ++r) {
            const __m512i row_index = _mm512_set1_epi32(static_cast<int>(r0 + r));
            // Padding rows must not win a column: their products count as -1.
            const __m512i value = r0 + r < d.rows ? acc[r][v] : _mm512_set1_epi32(-1);
            keep_top_two(value, row_index, best, second, index);
          }
          _mm512_store_si512(column.best, best);
          _mm512_store_si512(column.second, second);
          _mm512_store_si512(column.index, index);
        }
        for (size_t r = 0; r < kRowTile; ++r) {
          TopTwo<16>& top = t.rows[r0 + r];
          __m512i best = _mm512_load_si512(top.best), second = _mm512_load_si512(top.second),
                  index = _mm512_load_si512(top.index);
          for (size_t v = 0; v < 4; ++v) {
            const __m512i column_index = _mm512_add_epi32(lane, _mm512_set1_epi32(static_cast<int>(c0 + 16 * v)));
            const __mmask16 real = _mm512_cmplt_epi32_mask(column_index, _mm512_set1_epi32(static_cast<int>(d.columns)));
            keep_top_two(_mm512_mask_mov_epi32(_mm512_set1_epi32(-1), real, acc[r][v]), column_index, best, second, index);
          }
          _mm512_store_si512(top.best, best);
          _mm512_store_si512(top.second, second);
          _mm512_store_si512(top.index, index);
        }
      }
    }
  }
}

inline void keep_top_two(__m256i value, __m256i index, __m256i& best, __m256i& second, __m256i& best_index) {
  const __m256i better = _mm256_cmpgt_epi32(value, best);
  second = _mm256_max_epi32(second, _mm256_min_epi32(value, best));
  best = _mm256_max_epi32(best, value);
  best_index = _mm256_blendv_epi8(best_index, index, better);
}

// Tile of 4 rows x 2 vectors of 8 columns in 16-bit multiply-adds (a byte product of 8-bit madd would saturate).
void run_avx2(const KernelDesc& d, Tables<8>& t) {
  const int16_t* rows = static_cast<const int16_t*>(d.row_data);
  const int16_t* panels = static_cast<const int16_t*>(d.panel_data);
  const __m256i lane = _mm256_set_epi32(7, 6, 5, 4, 3, 2, 1, 0);
  constexpr size_t kPanel = kPanelColumns / 2;  // twice the bytes per value
  for (size_t panel = 0; panel < d.padded_columns; panel += kPanel) {
    const size_t panel_end = std::min(panel + kPanel, d.padded_columns);
    for (size_t r0 = 0; r0 < d.padded_rows; r0 += kAvx2RowTile) {
      const int16_t* row = rows + r0 * kDescriptorBytes;
      for (size_t c0 = panel; c0 < panel_end; c0 += 16) {
        __m256i acc[kAvx2RowTile][2];
        for (size_t r = 0; r < kAvx2RowTile; ++r) acc[r][0] = acc[r][1] = _mm256_setzero_si256();
        const int16_t* block = panels + c0 * kDescriptorBytes;
        for (size_t q = 0; q < kDescriptorBytes / 2; ++q) {
          const __m256i b0 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(block + q * 16));
          const __m256i b1 = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(block + 1024 + q * 16));
          for (size_t r = 0; r < kAvx2RowTile; ++r) {
            int32_t pair;
            std::memcpy(&pair, row + r * kDescriptorBytes + 2 * q, 4);
            const __m256i a = _mm256_set1_epi32(pair);
            acc[r][0] = _mm256_add_epi32(acc[r][0], _mm256_madd_epi16(b0, a));
            acc[r][1] = _mm256_add_epi32(acc[r][1], _mm256_madd_epi16(b1, a));
          }
        }
        for (size_t v = 0; v < 2; ++v) {
          TopTwo<8>& column = t.columns[c0 / 8 + v];
          __m256i* p = reinterpret_cast<__m256i*>(&column);
          __m256i best = _mm256_load_si256(p), second = _mm256_load_si256(p + 1), index = _mm256_load_si256(p + 2);
          for (size_t r = 0; r < kAvx2RowTile; ++r) {
            const __m256i value = r0 + r < d.rows ? acc[r][v] : _mm256_set1_epi32(-1);
            keep_top_two(value, _mm256_set1_epi32(static_cast<int>(r0 + r)), best, second, index);
          }
          _mm256_store_si256(p, best);
          _mm256_store_si256(p + 1, second);
          _mm256_store_si256(p + 2, index);
        }
        for (size_t r = 0; r < kAvx2RowTile; ++r) {
          __m256i* p = reinterpret_cast<__m256i*>(&t.rows[r0 + r]);
          __m256i best = _mm256_load_si256(p), second = _mm256_load_si256(p + 1), index = _mm256_load_si256(p + 2);
          for (size_t v = 0; v < 2; ++v) {
            const __m256i column_index = _mm256_add_epi32(lane, _mm256_set1_epi32(static_cast<int>(c0 + 8 * v)));
            const __m256i real = _mm256_cmpgt_epi32(_mm256_set1_epi32(static_cast<int>(d.columns)), column_index);
            keep_top_two(_mm256_blendv_epi8(_mm256_set1_epi32(-1), acc[r][v], real), column_index, best, second, index);
          }
          _mm256_store_si256(p, best);
          _mm256_store_si256(p + 1, second);
          _mm256_store_si256(p + 2, index);
        }
      }
    }
  }
}

struct Candidate {
  int32_t best = -1, second = -1, index = -1;
};

template <size_t Lanes>
Candidate reduced(const TopTwo<Lanes>& top) {
  Candidate c;
  for (size_t l = 0; l < Lanes; ++l) {
    const bool better = top.best[l] > c.best || (top.best[l] == c.best && top.best[l] >= 0 && top.index[l] < c.index);
    c.second = std::max({c.second, top.second[l], better ? c.best : top.best[l]});
    if (better) c.best = top.best[l], c.index = top.index[l];
  }
  return c;
}

double angle(int32_t product) {
  constexpr double kLengthSquared = 512.0 * 512.0;
  return product < 0 ? std::numbers::pi / 2 : std::acos(std::min(1.0, product / kLengthSquared));
}

// Index of the accepted neighbour, or -1.
int32_t accepted(const Candidate& c) {
  if (c.index < 0) return -1;
  const double first = angle(c.best);
  if (first > kMaxMatchAngle || first >= kMaxMatchRatio * angle(c.second)) return -1;
  return c.index;
}

template <size_t Lanes>
std::vector<Match> matches_of(const Tables<Lanes>& t, size_t rows, size_t columns) {
  std::vector<int32_t> back(columns, -1);
  for (size_t c = 0; c < columns; ++c) {
    const TopTwo<Lanes>& group = t.columns[c / Lanes];
    const size_t l = c % Lanes;
    back[c] = accepted({group.best[l], group.second[l], group.index[l]});
  }
  std::vector<Match> out;
  for (size_t r = 0; r < rows; ++r) {
    const int32_t c = accepted(reduced(t.rows[r]));
    if (c < 0 || back[static_cast<size_t>(c)] != static_cast<int32_t>(r)) continue;
    out.push_back({static_cast<uint32_t>(r), static_cast<uint32_t>(c)});
  }
  return out;
}

}  // namespace

bool available(MatchKernel kernel) {
  if (kernel != MatchKernel::Avx512Vnni) return true;
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
         __builtin_cpu_supports("avx512vnni");
}

PackedDescriptors::PackedDescriptors(std::span<const uint8_t> descriptors, MatchKernel kernel) {
  VITRINE_CHECK(descriptors.size() % kDescriptorBytes == 0, "{} bytes are no whole descriptors", descriptors.size());
  count_ = descriptors.size() / kDescriptorBytes;
  kernel_ = kernel == MatchKernel::Automatic ? (available(MatchKernel::Avx512Vnni) ? MatchKernel::Avx512Vnni : MatchKernel::Avx2)
                                             : kernel;
  VITRINE_CHECK(available(kernel_), "this machine has no AVX-512 VNNI");
  if (kernel_ == MatchKernel::Avx512Vnni) {
    padded_ = rounded_up(count_, 64);
    signed_rows_.assign(rounded_up(count_, kRowTile) * kDescriptorBytes, 0);
    for (size_t i = 0; i < descriptors.size(); ++i) signed_rows_[i] = static_cast<int8_t>(int(descriptors[i]) - 128);
    panels_.assign(padded_ * kDescriptorBytes, 0);
    offsets_.assign(padded_, 0);
    for (size_t i = 0; i < count_; ++i)
      for (size_t k = 0; k < kDescriptorBytes; ++k) {
        const uint8_t value = descriptors[i * kDescriptorBytes + k];
        panels_[i / 16 * 16 * kDescriptorBytes + k / 4 * 64 + i % 16 * 4 + k % 4] = value;
        offsets_[i] += 128 * value;
      }
  } else {
    padded_ = rounded_up(count_, 16);
    rows16_.assign(rounded_up(count_, kAvx2RowTile) * kDescriptorBytes, 0);
    std::copy(descriptors.begin(), descriptors.end(), rows16_.begin());
    panels16_.assign(padded_ * kDescriptorBytes, 0);
    for (size_t i = 0; i < count_; ++i)
      for (size_t k = 0; k < kDescriptorBytes; ++k)
        panels16_[i / 8 * 8 * kDescriptorBytes + k / 2 * 16 + i % 8 * 2 + k % 2] = descriptors[i * kDescriptorBytes + k];
  }
}

std::vector<Match> match(const PackedDescriptors& a, const PackedDescriptors& b) {
  if (a.size() == 0 || b.size() == 0) return {};
  VITRINE_CHECK(a.kernel_ == b.kernel_, "descriptors packed for two different kernels");
  KernelDesc d{.rows = a.count_, .columns = b.count_, .padded_columns = b.padded_};
  if (a.kernel_ == MatchKernel::Avx512Vnni) {
    d.padded_rows = a.signed_rows_.size() / kDescriptorBytes;
    d.row_data = a.signed_rows_.data();
    d.panel_data = b.panels_.data();
    d.offsets = b.offsets_.data();
    thread_local Tables<16> t;
    reset(t.rows, d.padded_rows);
    reset(t.columns, d.padded_columns / 16);
    run_vnni(d, t);
    return matches_of(t, d.rows, d.columns);
  }
  d.padded_rows = a.rows16_.size() / kDescriptorBytes;
  d.row_data = a.rows16_.data();
  d.panel_data = b.panels16_.data();
  thread_local Tables<8> t;
  reset(t.rows, d.padded_rows);
  reset(t.columns, d.padded_columns / 8);
  run_avx2(d, t);
  return matches_of(t, d.rows, d.columns);
}

}  // namespace vitrine

#pragma GCC diagnostic pop
