// Quantiles and median of values without NaN, in linear time (std::nth_element). Functions that take a span reorder its values.
//
// quantile_of() returns element floor(share (n - 1)) of n values in ascending order, without interpolation; share 0 is the
// smallest value, 1 the largest. The product is computed in the type of the share.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

namespace vitrine {

// 0-based, 0 = smallest; `number` is less than the size.
template <class T>
T order_statistic_of(std::span<T> values, size_t number) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(number);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Requires at least one value.
template <class T, std::floating_point Share>
T quantile_of(std::span<T> values, Share share) {
  return order_statistic_of(values, static_cast<size_t>(share * static_cast<Share>(values.size() - 1)));
}
template <class T, std::floating_point Share>
T quantile_of(std::vector<T>& values, Share share) {
  return quantile_of(std::span<T>(values), share);
}

// Mean of the two middle values for an even number; NaN if empty. upper_median() (median.h) returns the upper one.
inline double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const double upper = order_statistic_of(std::span<double>(values), values.size() / 2);
  if (values.size() % 2 == 1) return upper;
  return 0.5 * (upper + *std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2)));
}

}  // namespace vitrine
