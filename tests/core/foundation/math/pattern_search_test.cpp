#include "core/foundation/math/pattern_search.h"

#include <gtest/gtest.h>

#include <array>

namespace vitrine {
namespace {

using Numbers = std::array<double, 2>;
constexpr std::array<size_t, 2> kBoth{0, 1};

// A crooked hill with its top at (1, -2).
double hill(const Numbers& x) {
  const double u = x[0] - 1, v = x[1] + 2;
  return 5 - u * u - v * v - u * v;
}

std::optional<Numbers> moved_number(Numbers x, size_t number, double step) {
  x[number] += step;
  return x;
}

TEST(PatternSearch, ClimbsToTheTopAndReturnsItsScore) {
  Numbers x{4, 4};
  const double best = pattern_search(hill, moved_number, {1, 1e-5}, kBoth, x);
  EXPECT_NEAR(x[0], 1, 1e-4);
  EXPECT_NEAR(x[1], -2, 1e-4);
  EXPECT_EQ(best, hill(x));
  EXPECT_NEAR(best, 5, 1e-8);
}

TEST(PatternSearch, KeepsTheOtherNumbersAndStaysWhereMovesArePossible) {
  Numbers x{4, 4};
  pattern_search(hill, moved_number, {1, 1e-5}, std::span(kBoth).first(1), x);
  EXPECT_NEAR(x[0], -2, 1e-4);  // the best for x[1] = 4
  EXPECT_EQ(x[1], 4);
  const auto bounded = [](const Numbers& from, size_t number, double step) {
    const auto to = moved_number(from, number, step);
    return (*to)[0] < 2 ? std::nullopt : to;
  };
  x = {4, 4};
  pattern_search(hill, bounded, {1, 1e-5}, kBoth, x);
  EXPECT_NEAR(x[0], 2, 1e-4);
}

TEST(PatternSearch, IgnoresGainsThatAreSmallForTheScore) {
  const auto slope = [](const Numbers& x) { return 1e6 + 1e-5 * x[0]; };
  Numbers x{0, 0};
  pattern_search(slope, moved_number, {1, 0.5, true}, kBoth, x);
  EXPECT_EQ(x[0], 0);
  const auto bounded = [](const Numbers& from, size_t number, double step) {
    return from[0] + step > 3 ? std::nullopt : moved_number(from, number, step);
  };
  pattern_search(slope, bounded, {1, 0.5}, kBoth, x);
  EXPECT_EQ(x[0], 3);
}

}  // namespace
}  // namespace vitrine
