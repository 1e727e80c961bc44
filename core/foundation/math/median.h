// Upper median by selection.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace vitrine {

// Ratio of standard deviation to median absolute deviation (MAD) for a normal distribution.
inline constexpr double kSigmaPerDeviation = 1.4826;

// For an even number of values the upper of the two middle ones. `values` must be non-empty and without NaN; they are
// reordered.
template <class T>
T upper_median_of(std::span<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
// Same, on a copy.
template <class T>
T upper_median(std::vector<T> values) {
  return upper_median_of(std::span<T>(values));
}

}  // namespace vitrine
