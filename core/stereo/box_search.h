// Pattern search (Hooke and Jeeves 1961) over the nine numbers of a box: six faces, three angles.
#pragma once

#include <array>
#include <span>

#include "core/shape/box.h"

namespace vitrine {

// About one of the axes, radians.
Mat3d turned(size_t axis, double angle);
// Moves face `i` (low and high of each axis) outwards by `step` of the diagonal, or, for i = 6 to 8, turns the box about its
// middle by `step` radians.
Box moved(const Box& box, size_t i, double step);

inline constexpr std::array<size_t, 9> kBoxNumbers{0, 1, 2, 3, 4, 5, 6, 7, 8};  // as moved() counts them

// One number at a time, shorter steps where none helps; `score` (of a box) grows, and is what it was brought to.
template <class Score>
double improve(const Score& score, double step, double last_step, Box& box, std::span<const size_t> numbers = kBoxNumbers) {
  double best = score(box);
  for (; step >= last_step; step *= 0.5)
    for (bool better = true; better;) {
      better = false;
      for (size_t i : numbers)
        for (double sign : {1.0, -1.0}) {
          const Box trial = moved(box, i, sign * step);
          if (!(trial.high.x > trial.low.x && trial.high.y > trial.low.y && trial.high.z > trial.low.z)) continue;
          const double s = score(trial);
          if (s > best + 1e-9) best = s, box = trial, better = true;
        }
    }
  return best;
}

}  // namespace vitrine
