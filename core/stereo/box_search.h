// Pattern search over the numbers of a box: six faces and three angles.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/math/pattern_search.h"
#include "core/shape/box.h"

namespace vitrine {

// About one of the axes, radians.
Mat3d turned(size_t axis, double angle);
// Moves face `i` (low and high of each axis) outwards by `step` of the diagonal, or, for i = 6 to 8, turns the box about its
// middle by `step` radians.
Box moved(const Box& box, size_t i, double step);

inline constexpr std::array<size_t, 9> kBoxNumbers{0, 1, 2, 3, 4, 5, 6, 7, 8};  // as moved() counts them

// Raises score(box), and returns what it was raised to.
template <class Score>
double improve(const Score& score, double step, double last_step, Box& box, std::span<const size_t> numbers = kBoxNumbers) {
  const auto move = [](const Box& from, size_t i, double by) -> std::optional<Box> {
    const Box trial = moved(from, i, by);
    if (!(trial.high.x > trial.low.x && trial.high.y > trial.low.y && trial.high.z > trial.low.z)) return std::nullopt;
    return trial;
  };
  return pattern_search(score, move, {step, last_step}, numbers, box);
}

}  // namespace vitrine
