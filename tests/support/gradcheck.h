// Gradient comparison that is hard to fool. A maximum of componentwise errors hides a missing row among large ones, a cosine
// hides a wrong length, an L2 hides a bias: so all are looked at, and "both are zero" is a failure, not a success.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <string>
#include <vector>

namespace vitrine {

struct GradTolerance {
  double relative_l2 = 1e-4;  // |actual - expected| / |expected|
  double bias = 1e-4;         // |sum (actual - expected) sign(expected)| / sum |expected|
  double min_norm = 1e-12;    // precondition: |expected| is larger
  size_t row_width = 1;       // components to a row; a row is empty when all of it is zero
  double row_floor = 1e-6;    // rows of `expected` smaller than this times the largest are not held against `actual`
};

struct GradReport {
  double relative_l2 = 0, cosine = 0, bias = 0, norm = 0;
  size_t empty_rows = 0;  // rows that `expected` has and `actual` lacks
  size_t not_finite = 0;

  // Empty when fine, else what is wrong.
  std::string problem(const GradTolerance& t) const {
    if (not_finite > 0) return std::to_string(not_finite) + " components are not finite";
    if (!(norm > t.min_norm)) return "the expected gradient is zero: nothing was tested (norm " + std::to_string(norm) + ")";
    if (empty_rows > 0) return std::to_string(empty_rows) + " rows are empty that should not be";
    if (!(relative_l2 <= t.relative_l2)) return "relative L2 " + std::to_string(relative_l2);
    if (!(cosine >= 1 - 2 * t.relative_l2)) return "cosine " + std::to_string(cosine);
    if (!(std::abs(bias) <= t.bias)) return "signed bias " + std::to_string(bias);
    return "";
  }
};

template <class A, class E>
GradReport compare_gradients(std::span<const A> actual, std::span<const E> expected, const GradTolerance& t) {
  GradReport r;
  double aa = 0, ee = 0, ae = 0, difference = 0, signed_sum = 0, absolute_sum = 0;
  for (size_t i = 0; i < expected.size() && i < actual.size(); ++i) {
    const double a = static_cast<double>(actual[i]), e = static_cast<double>(expected[i]);
    if (!std::isfinite(a) || !std::isfinite(e)) ++r.not_finite;
    aa += a * a;
    ee += e * e;
    ae += a * e;
    difference += (a - e) * (a - e);
    signed_sum += e < 0 ? e - a : a - e;
    absolute_sum += std::abs(e);
  }
  if (actual.size() != expected.size()) ++r.not_finite;
  r.norm = std::sqrt(ee);
  r.relative_l2 = std::sqrt(difference / ee);
  r.cosine = ae / std::sqrt(aa * ee);
  r.bias = signed_sum / absolute_sum;
  double largest = 0;
  std::vector<double> rows_expected, rows_actual;
  for (size_t i = 0; i + t.row_width <= expected.size() && i + t.row_width <= actual.size(); i += t.row_width) {
    double e = 0, a = 0;
    for (size_t c = 0; c < t.row_width; ++c) {
      e = std::max(e, std::abs(static_cast<double>(expected[i + c])));
      a = std::max(a, std::abs(static_cast<double>(actual[i + c])));
    }
    rows_expected.push_back(e);
    rows_actual.push_back(a);
    largest = std::max(largest, e);
  }
  for (size_t i = 0; i < rows_expected.size(); ++i)
    if (rows_expected[i] > t.row_floor * largest && rows_actual[i] == 0) ++r.empty_rows;
  return r;
}

// gtest form; returns the report so that a test can record the worst value seen.
template <class A, class E>
GradReport expect_grad_close(const std::vector<A>& actual, const std::vector<E>& expected, const GradTolerance& t,
                             const std::string& what = "") {
  const GradReport r = compare_gradients(std::span<const A>(actual), std::span<const E>(expected), t);
  EXPECT_EQ(r.problem(t), "") << what << ": relative L2 " << r.relative_l2 << ", cosine " << r.cosine << ", bias " << r.bias
                              << ", norm " << r.norm << ", empty rows " << r.empty_rows;
  return r;
}

// d f / d x by central differences; f reads x.
template <class T, class F>
double finite_difference(T& x, F f, double step = 1e-6) {
  const T kept = x;
  x = static_cast<T>(double(kept) + step);
  const double above = f();
  x = static_cast<T>(double(kept) - step);
  const double below = f();
  x = kept;
  return (above - below) / (2 * step);
}

template <class F>
std::vector<double> finite_differences(std::vector<double>& x, F f, double step = 1e-6) {
  std::vector<double> g;
  for (double& v : x) g.push_back(finite_difference(v, f, step));
  return g;
}

// The same for parameters in float, whose steps must be long: the error of two of them is extrapolated away, up to O(step^4).
template <class F>
std::vector<double> extrapolated_differences(std::span<float> x, F f, float step = 2e-3f) {
  std::vector<double> g;
  for (float& v : x) {
    const float kept = v;
    const auto slope = [&](float h) {
      v = kept + h;
      const double above = f();
      v = kept - h;
      const double below = f();
      v = kept;
      return (above - below) / (2 * double(h));
    };
    g.push_back((4 * slope(step) - slope(2 * step)) / 3);
  }
  return g;
}

}  // namespace vitrine
