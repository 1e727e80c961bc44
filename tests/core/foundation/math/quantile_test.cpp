#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {
namespace {

TEST(Quantile, IsTheSortedValueAtTheRoundedDownPlace) {
  Rng rng(5);
  for (size_t n : {1u, 2u, 3u, 50u, 101u}) {
    std::vector<double> values(n);
    for (double& v : values) v = std::floor(20 * rng.uniform_double());  // with ties
    std::vector<double> sorted = values;
    std::ranges::sort(sorted);
    for (double share : {0.0, 0.02, 0.4, 0.5, 0.98, 1.0}) {
      std::vector<double> copy = values;
      EXPECT_EQ(quantile_of(copy, share), sorted[size_t(share * double(n - 1))]) << n << " " << share;
    }
    for (size_t i = 0; i < n; ++i) {
      std::vector<double> copy = values;
      EXPECT_EQ(order_statistic_of(std::span(copy), i), sorted[i]);
    }
  }
}

TEST(Quantile, ComputesThePlaceInTheTypeOfTheShare) {
  std::vector<int> values(11);
  for (int i = 0; i < 11; ++i) values[size_t(i)] = 10 - i;
  EXPECT_EQ(quantile_of(values, 0.7), 7);
  EXPECT_EQ(quantile_of(values, 0.7f), size_t(0.7f * 10.f));
  EXPECT_EQ(quantile_of(values, 0.25), 2);
  std::ranges::sort(values);
  EXPECT_EQ(values.back(), 10) << "only the order has changed";
}

TEST(Median, IsTheMeanOfTheTwoInTheMiddleTheUpperMedianTheUpperOne) {
  EXPECT_EQ(median({4, 1, 3, 2}), 2.5);
  EXPECT_EQ(median({5, 1, 3}), 3);
  EXPECT_TRUE(std::isnan(median({})));
  EXPECT_EQ(upper_median(std::vector{4, 1, 3, 2}), 3);
}

}  // namespace
}  // namespace vitrine
