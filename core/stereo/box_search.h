// Pattern search (Hooke and Jeeves 1961) over the numbers of a shape: of a box six faces and three angles.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/shape/box.h"

namespace vitrine {

// About one of the axes, radians.
Mat3d turned(size_t axis, double angle);
// Moves face `i` (low and high of each axis) outwards by `step` of the diagonal, or, for i = 6 to 8, turns the box about its
// middle by `step` radians.
Box moved(const Box& box, size_t i, double step);

inline constexpr std::array<size_t, 9> kBoxNumbers{0, 1, 2, 3, 4, 5, 6, 7, 8};  // as moved() counts them

// One number at a time, shorter steps where none helps; `score` (of a shape) grows, and is what it was brought to.
// move(shape, i, step): the shape with number i moved; nullopt where there is none.
template <class S, class Score, class Move>
double climb(const Score& score, const Move& move, double step, double last_step, S& shape, std::span<const size_t> numbers) {
  double best = score(shape);
  for (; step >= last_step; step *= 0.5)
    for (bool better = true; better;) {
      better = false;
      for (size_t i : numbers)
        for (double sign : {1.0, -1.0}) {
          const std::optional<S> trial = move(shape, i, sign * step);
          if (!trial) continue;
          const double s = score(*trial);
          if (s > best + 1e-9) best = s, shape = *trial, better = true;
        }
    }
  return best;
}

template <class Score>
double improve(const Score& score, double step, double last_step, Box& box, std::span<const size_t> numbers = kBoxNumbers) {
  const auto move = [](const Box& from, size_t i, double by) -> std::optional<Box> {
    const Box trial = moved(from, i, by);
    if (!(trial.high.x > trial.low.x && trial.high.y > trial.low.y && trial.high.z > trial.low.z)) return std::nullopt;
    return trial;
  };
  return climb(score, move, step, last_step, box, numbers);
}

}  // namespace vitrine
