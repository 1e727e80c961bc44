// The middle value.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace vitrine {

// Standard deviation of a normal distribution over its median absolute deviation.
inline constexpr double kSigmaPerDeviation = 1.4826;

// Of an even number of values the upper one of the two in the middle; they must not be empty, nor hold NaN. Puts them in another
// order.
template <class T>
T upper_median_of(std::span<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}
// The same, of a copy.
template <class T>
T upper_median(std::vector<T> values) {
  return upper_median_of(std::span<T>(values));
}

}  // namespace vitrine
