// Deterministic sums over an image: one double per row, added in row order, so that any number of threads gives the same bits.
#pragma once

#include <span>
#include <vector>

#include "core/foundation/base/parallel.h"

namespace vitrine {

inline constexpr size_t kRowGrain = 8;

// Sum over rows of body(row).
template <class Body>
double sum_over_rows(size_t rows, std::vector<double>& scratch, const Body& body) {
  scratch.resize(rows);
  parallel_for(rows, kRowGrain, [&](size_t y) { scratch[y] = body(y); });
  double sum = 0;
  for (double s : scratch) sum += s;
  return sum;
}

inline double sum_of(std::span<const float> values) {
  double sum = 0;
  for (float v : values) sum += v;
  return sum;
}

}  // namespace vitrine
