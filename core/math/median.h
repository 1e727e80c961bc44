// The middle value.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace vitrine {

// Of an even number of values the upper one of the two in the middle; they must not be empty, nor hold NaN.
template <class T>
T upper_median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace vitrine
