#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>

namespace vitrine {

struct PatternSteps {
  double first, last;          // step size, halved from `first` down to `last`
  bool relative_gain = false;  // minimum gain of a move: 1e-9 of the score if true, else 1e-9
};

// Coordinate pattern search (Hooke-Jeeves). Returns the best score.
// Maximises score(x) by moves of one of the `numbers` coordinates at a time; halves the step when no move improves the score.
// move(x, number, step): x with that coordinate moved; nullopt if not allowed.
template <class X, class Score, class Move>
double pattern_search(const Score& score, const Move& move, const PatternSteps& steps, std::span<const size_t> numbers, X& x) {
  double best = score(x);
  for (double step = steps.first; step >= steps.last; step *= 0.5)
    for (bool better = true; better;) {
      better = false;
      for (const size_t number : numbers)
        for (const double sign : {1.0, -1.0}) {
          const std::optional<X> trial = move(x, number, sign * step);
          if (!trial) continue;
          const double s = score(*trial);
          if (s > best + 1e-9 * (steps.relative_gain ? std::abs(best) : 1.0)) best = s, x = *trial, better = true;
        }
    }
  return best;
}

}  // namespace vitrine
