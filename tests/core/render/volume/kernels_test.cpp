// Closed form of the line integral against quadrature, and reverses of kernels and reference against dual numbers and
// finite differences.
#include <gtest/gtest.h>

#include "core/foundation/math/dual.h"
#include "core/render/volume/kernels/density.h"
#include "core/render/volume/kernels/exponential.h"
#include "core/render/volume/reference/reference.h"
#include "tests/core/render/volume/gaussian_sets.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

constexpr size_t kValues = Gaussian3d::kValues;
using D = Dual<double, kValues>;

Gaussian3<D> variables(const Gaussian3d& g) {
  std::array<D, kValues> v;
  const auto values = values_of(g);
  for (size_t i = 0; i < kValues; ++i) v[i] = D::variable(values[i], i);
  return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8], v[9]}, v[10]};
}

TEST(VolumeKernels, LineIntegralIsTheQuadratureOfTheDensity) {
  for (const Gaussian3d& g : test::random_gaussians(20, {0.2, -0.1, 0.3}, 1)) {
    const Whitened<double> w = whitened(g);
    const Vec3d origin = g.mean + Vec3d{3, 0.1, -0.05}, direction = normalized(Vec3d{-1, 0.02, 0.04});
    constexpr int kSteps = 60000;
    constexpr double kLength = 6;
    double sum = 0;  // the trapezoidal rule converges exponentially for a smooth function that vanishes at both ends
    for (int i = 0; i < kSteps; ++i)
      sum += kLength / kSteps * density_at(w, g.mean, origin + (kLength * (i + 0.5) / kSteps) * direction);
    const double closed = line_integral(w, whitened_line(w, g.mean, origin, direction));
    EXPECT_NEAR(closed, sum, 1e-10 * (closed + 1e-3));
  }
}

TEST(VolumeKernels, LineIntegralOfASphereIsKnown) {
  Gaussian3d g;
  g.log_scale = {std::log(0.5), std::log(0.5), std::log(0.5)}, g.log_density = std::log(3.);
  const Whitened<double> w = whitened(g);
  const double through = line_integral(w, whitened_line(w, g.mean, Vec3d{0, 0, -7}, Vec3d{0, 0, 1}));
  const double past = line_integral(w, whitened_line(w, g.mean, Vec3d{0.5, 0, -7}, Vec3d{0, 0, 1}));
  EXPECT_NEAR(through, 3 * 0.5 * std::sqrt(2 * std::numbers::pi), 1e-14);
  EXPECT_NEAR(past, through * std::exp(-0.5), 1e-14);
}

TEST(VolumeKernels, ReversesAgreeWithDualNumbers) {
  const Vec3d at{0.1, -0.3, 0.2}, direction = normalized(Vec3d{0.4, -1, 0.3});
  const Vec3<D> at_dual = cast<D>(at), direction_dual = cast<D>(direction);
  std::vector<double> line, line_expected;
  for (const Gaussian3d& g : test::random_gaussians(30, {}, 2)) {
    const Whitened<double> w = whitened(g);
    const Gaussian3<D> v = variables(g);
    const Whitened<D> wd = whitened(v);
    WhitenedGradient<double> of_line;
    line_integral_vjp(w, g.mean, at, direction, 1.7, of_line);
    const D l = line_integral(wd, whitened_line(wd, v.mean, at_dual, direction_dual));
    const auto a = values_of(whitened_vjp(g, w, of_line));
    for (size_t i = 0; i < kValues; ++i) line.push_back(a[i]), line_expected.push_back(1.7 * l.d[i]);
  }
  const GradTolerance tolerance{.relative_l2 = 1e-12, .bias = 1e-12};
  EXPECT_EQ((compare_gradients<double, double>(line, line_expected, tolerance).problem(tolerance)), "");
}

TEST(VolumeKernels, ReferenceAgreesWithFiniteDifferences) {
  std::vector<Gaussian3d> set = test::random_gaussians(6, {}, 3);
  const std::vector<VolumeRay> rays = test::cone_rays(9, 7, {}, 4, 0.7);
  std::vector<double> weights(rays.size()), expected;
  for (size_t i = 0; i < rays.size(); ++i) weights[i] = double(Rng(5, i).normal());
  const auto loss = [&] {
    const std::vector<double> values = reference_line_integrals(set, rays);
    double sum = 0;
    for (size_t i = 0; i < values.size(); ++i) sum += weights[i] * values[i];
    return sum;
  };
  const std::vector<double> actual = test::flat(reference_line_integrals_vjp(set, rays, weights));
  for (Gaussian3d& g : set) {
    const auto values = values_of(g);
    for (size_t v = 0; v < kValues; ++v) {
      constexpr double kStep = 1e-5;
      double sides[2];
      for (int side = 0; side < 2; ++side) {
        auto moved = values;
        moved[v] += side == 0 ? -kStep : kStep;
        g = gaussian3(moved);
        sides[side] = loss();
      }
      g = gaussian3(values);
      expected.push_back((sides[1] - sides[0]) / (2 * kStep));
    }
  }
  const GradTolerance tolerance{.relative_l2 = 1e-7, .bias = 1e-7};
  EXPECT_EQ((compare_gradients<double, double>(actual, expected, tolerance).problem(tolerance)), "");
}

TEST(VolumeKernels, ExponentialIsExactToFloat) {
  for (int i = 0; i <= 8700; ++i) {
    const float x = -0.01f * float(i);
    const double exact = std::exp(double(std::max(x, -87.f)));
    EXPECT_NEAR(double(exponential(x)), exact, (x > -6 ? 1e-6 : 1e-5) * exact) << x;
  }
  EXPECT_LT(exponential(-1e30f), 1e-37f);
}

}  // namespace
}  // namespace vitrine
