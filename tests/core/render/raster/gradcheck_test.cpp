// The checker is checked: every way of being wrong that it promises to see.
#include "tests/support/gradcheck.h"

#include <gtest/gtest.h>

#include <limits>

namespace vitrine {
namespace {

const std::vector<double> kTruth{1, -2, 3, 0.5, -0.25, 4};
std::string problem(std::vector<double> actual, GradTolerance t = {}) {
  return compare_gradients(std::span<const double>(actual), std::span<const double>(kTruth), t).problem(t);
}

TEST(GradCheck, AcceptsTheTruth) { EXPECT_EQ(problem(kTruth), ""); }

TEST(GradCheck, SeesAWrongComponent) {
  std::vector<double> wrong = kTruth;
  wrong[3] = -wrong[3];
  EXPECT_NE(problem(wrong).find("relative L2"), std::string::npos);
}

TEST(GradCheck, SeesABiasThatAWideL2WouldForgive) {
  std::vector<double> scaled = kTruth;
  for (double& v : scaled) v *= 1.01;
  EXPECT_NE(problem(scaled, {.relative_l2 = 0.02, .bias = 1e-3}).find("bias"), std::string::npos);
}

TEST(GradCheck, SeesAnEmptyRowAmongLargeOnes) {
  std::vector<double> wrong = kTruth;
  wrong[3] = wrong[2] = 0;
  EXPECT_NE(problem(wrong, {.relative_l2 = 10, .row_width = 2}).find("rows are empty"), std::string::npos);
}

TEST(GradCheck, RefusesToCompareZeroWithZero) {
  const std::vector<double> zero(6, 0.0);
  const GradTolerance t;
  EXPECT_NE(compare_gradients(std::span<const double>(zero), std::span<const double>(zero), t).problem(t), "");
}

TEST(GradCheck, RefusesWhatIsNotFiniteOrShort) {
  std::vector<double> wrong = kTruth;
  wrong[1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(problem(wrong), "");
  wrong = kTruth;
  wrong.pop_back();
  EXPECT_NE(problem(wrong), "");
}

TEST(GradCheck, DifferentiatesAKnownFunction) {
  std::vector<double> x{0.3, -1.2};
  const std::vector<double> g = finite_differences(x, [&] { return std::sin(x[0]) * x[1] * x[1]; });
  expect_grad_close(g, std::vector<double>{std::cos(0.3) * 1.44, 2 * std::sin(0.3) * -1.2}, {.relative_l2 = 1e-8, .bias = 1e-8});
}

TEST(GradCheck, ExtrapolatesAwayTheErrorOfLongSteps) {
  std::vector<float> x{0.3f, -1.2f};
  const auto f = [&] { return std::sin(double(x[0])) * std::exp(double(x[1])); };
  const std::vector<double> truth{std::cos(0.3) * std::exp(-1.2), std::sin(0.3) * std::exp(-1.2)};
  const std::vector<double> g = extrapolated_differences(x, f, 0.1f);  // central differences alone: off by 1.7e-3
  expect_grad_close(g, truth, {.relative_l2 = 5e-5, .bias = 5e-5});
  EXPECT_EQ(x, (std::vector<float>{0.3f, -1.2f}));
}

}  // namespace
}  // namespace vitrine
