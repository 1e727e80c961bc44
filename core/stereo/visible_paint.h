// Paint or mirror? Paint looks alike from everywhere, and gloss adds to it here and there; what a metal shows changes with the
// view as much as its surroundings do. Told by what several photos show of a place: the mean of their lower-half mean ratio, over
// the mean of all.
#pragma once

#include <algorithm>
#include <vector>

namespace vitrine {

// `luminances` of one place in several photos, at least one; they are put in another order. 1 where all are black.
inline float lower_half_mean_ratio(std::vector<float>& luminances) {
  const size_t half = (luminances.size() + 1) / 2;
  std::ranges::nth_element(luminances, luminances.begin() + static_cast<std::ptrdiff_t>(half - 1));
  double dim = 0, all = 0;
  for (size_t i = 0; i < luminances.size(); ++i) {
    all += luminances[i];
    if (i < half) dim += luminances[i];
  }
  return all > 0 ? static_cast<float>(dim / double(half) * double(luminances.size()) / all) : 1.f;
}

}  // namespace vitrine
