// Emission and absorption: kernels against dual numbers, the quadrature of the reference against a plain march along the ray,
// its reverse against finite differences, and cells where they are exact.
#include <gtest/gtest.h>

#include "core/foundation/math/dual.h"
#include "core/render/volume/cell_nodes.h"
#include "core/render/volume/kernels/cells.h"
#include "core/render/volume/reference/reference.h"
#include "tests/core/render/volume/gaussian_sets.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

TEST(VolumeProfile, ReverseAgreesWithDualNumbers) {
  using D = Dual<double, Gaussian3d::kValues>;
  const Vec3d origin{0.1, -0.3, 0.2}, direction = normalized(Vec3d{0.4, -1, 0.3});
  std::vector<double> actual, expected;
  for (const Gaussian3d& g : test::random_gaussians(30, {}, 2)) {
    std::array<D, Gaussian3d::kValues> v;
    for (size_t i = 0; i < v.size(); ++i) v[i] = D::variable(values_of(g)[i], i);
    const Gaussian3<D> variables{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8], v[9]}, v[10]};
    const Whitened<D> wd = whitened(variables);
    const RayProfile<D> p = ray_profile(wd, whitened_line(wd, variables.mean, cast<D>(origin), cast<D>(direction)));
    const D loss = D(1.7) * p.depth - D(0.4) * p.at + D(2.3) * p.width;
    const Whitened<double> w = whitened(g);
    WhitenedGradient<double> sums;
    ray_profile_vjp(w, g.mean, origin, direction, RayProfile<double>{1.7, -0.4, 2.3}, sums);
    const auto values = values_of(whitened_vjp(g, w, sums));
    for (size_t i = 0; i < v.size(); ++i) actual.push_back(values[i]), expected.push_back(loss.d[i]);
  }
  const GradTolerance tolerance{.relative_l2 = 1e-12, .bias = 1e-12};
  EXPECT_EQ((compare_gradients<double, double>(actual, expected, tolerance).problem(tolerance)), "");
}

TEST(VolumeCells, ReverseAgreesWithDualNumbers) {
  using D = Dual<double, 12>;  // depth and emission of three cells
  const Vec3d g{0.7, -1.1, 0.4};
  constexpr double kOfTransmittance = 0.9;
  std::vector<double> actual, expected;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    std::vector<RayCell<double>> cells(3);
    std::vector<double> before;
    VolumeLight<D> dual{{}, D(1.)};
    VolumeLightd light{{}, 1};
    Rng rng(9, seed);
    for (size_t k = 0; k < 3; ++k) {
      cells[k] = {1.2 * rng.uniform_double() * rng.uniform_double(), {rng.uniform_double(), rng.uniform_double(), 0.3}};
      const auto variable = [&](double value, size_t i) { return D::variable(value, 4 * k + i); };
      const RayCell<D> cell{
          variable(cells[k].depth, 0),
          {variable(cells[k].emission.x, 1), variable(cells[k].emission.y, 2), variable(cells[k].emission.z, 3)}};
      add_cell(cell, exp(-cell.depth), dual);
      before.push_back(light.transmittance);
      add_cell(cells[k], std::exp(-cells[k].depth), light);
    }
    const D loss = dot(cast<D>(g), dual.color) + D(kOfTransmittance) * dual.transmittance;
    double behind = kOfTransmittance * light.transmittance;
    std::vector<RayCell<double>> grad(3);
    for (size_t k = 3; k-- > 0;) grad[k] = add_cell_vjp(cells[k], std::exp(-cells[k].depth), before[k], g, behind);
    for (size_t k = 0; k < 3; ++k) {
      for (const double v : {grad[k].depth, grad[k].emission.x, grad[k].emission.y, grad[k].emission.z}) actual.push_back(v);
      expected.insert(expected.end(), loss.d.begin() + std::ptrdiff_t(4 * k), loss.d.begin() + std::ptrdiff_t(4 * k + 4));
    }
  }
  const GradTolerance tolerance{.relative_l2 = 1e-12, .bias = 1e-12};
  EXPECT_EQ((compare_gradients<double, double>(actual, expected, tolerance).problem(tolerance)), "");
}

TEST(VolumeCells, ShareAndItsSlopeAreContinuousWhereTheSeriesEnds) {
  for (const double a : {0., 1e-12, 0.1, 0.3 - 1e-9, 0.3 + 1e-9, 2., 40.}) {
    const double share = a == 0 ? 1 : -std::expm1(-a) / a;
    EXPECT_NEAR(cell_share(a, std::exp(-a)), share, 1e-14) << a;
    if (a > 0.01) {
      EXPECT_NEAR(cell_share_slope(a, std::exp(-a)), (std::exp(-a) - share) / a, 1e-12) << a;
    }
    EXPECT_NEAR(double(cell_share(float(a), float(std::exp(-a)))), share, 5e-7) << a;
    EXPECT_NEAR(double(cell_share_slope(float(a), float(std::exp(-a)))), cell_share_slope(a, std::exp(-a)), 2e-6) << a;
  }
}

TEST(VolumeCells, NormalDistributionIsExactToFloat) {
  for (int i = -2000; i <= 2000; ++i) {
    const double x = 0.01 * i;
    const NormalCdf cdf = normal_cdf(float(x));
    EXPECT_NEAR(double(cdf.below), normal_cdf(x), 3e-7) << x;
    EXPECT_NEAR(double(cdf.density), std::exp(-0.5 * x * x) / kSqrtTwoPi, 2e-7) << x;
  }
}

TEST(VolumeCells, BordersAreCloseWhereLightComesFrom) {
  const std::vector<TileProfile> profiles{{3, 0, 0.1}, {3, 2, 0.1}, {3, 8, 0.1}};
  const std::vector<float> nodes = cell_nodes(profiles, 32);
  ASSERT_EQ(nodes.size(), 31u);
  EXPECT_TRUE(std::is_sorted(nodes.begin(), nodes.end()));
  const auto within = [&](double low, double high) {
    return std::count_if(nodes.begin(), nodes.end(), [&](float t) { return double(t) > low && double(t) < high; });
  };
  EXPECT_GT(within(-0.2, 0.2), 2 * within(7.8, 8.2));  // the last is hidden by the others
  EXPECT_GT(within(1.8, 2.2), within(7.8, 8.2));
  EXPECT_GE(within(0.2, 1.8) + within(2.2, 7.8), 1);
  EXPECT_EQ(cell_nodes({}, 8).size(), 7u);
}

struct Emitters {
  std::vector<Gaussian3d> set;
  std::vector<Vec3d> colors;
  EmittingGaussians volume() const { return {set, colors}; }
};
Emitters emitters(size_t count, double log_density, uint64_t seed) {
  Emitters e{test::random_gaussians(count, {}, seed), {}};
  for (size_t i = 0; i < count; ++i) {
    e.set[i].log_density += log_density;
    Rng rng(seed + 1000, i);
    e.colors.push_back({rng.uniform_double(), rng.uniform_double(), rng.uniform_double()});
  }
  return e;
}

TEST(EmissionReference, IsAMarchAlongTheRay) {
  const Emitters e = emitters(40, 1.5, 31);
  const std::vector<VolumeRay> rays = test::cone_rays(3, 2, {}, 4, 0.4);
  const std::vector<VolumeLightd> actual = reference_emission(e.volume(), rays);
  std::vector<Whitened<double>> white;
  for (const Gaussian3d& g : e.set) white.push_back(whitened(g));
  double least = 1;
  for (size_t r = 0; r < rays.size(); ++r) {
    VolumeLightd sum{{}, 1};
    constexpr int kSteps = 8000;
    constexpr double kLength = 8, kStep = kLength / kSteps;
    for (int k = 0; k < kSteps; ++k) {
      RayCell<double> cell;
      for (size_t i = 0; i < e.set.size(); ++i) {
        const double depth =
            kStep * density_at(white[i], e.set[i].mean, rays[r].origin + (kStep * (k + 0.5)) * rays[r].direction);
        cell.depth += depth;
        cell.emission += depth * e.colors[i];
      }
      add_cell(cell, std::exp(-cell.depth), sum);
    }
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(actual[r].color[c], sum.color[c], 2e-6) << "ray " << r;
    EXPECT_NEAR(actual[r].transmittance, sum.transmittance, 1e-9);
    least = std::min(least, sum.transmittance);
  }
  EXPECT_LT(least, 0.3) << "too thin to test absorption";
}

TEST(EmissionReference, ReverseAgreesWithFiniteDifferences) {
  Emitters e = emitters(6, 2, 32);
  const std::vector<VolumeRay> rays = test::cone_rays(7, 5, {}, 4, 0.7);
  std::vector<VolumeLightd> weights;
  for (size_t i = 0; i < rays.size(); ++i) {
    Rng rng(5, i);
    const auto normal = [&] { return double(rng.normal()); };
    weights.push_back({{normal(), normal(), normal()}, normal()});
  }
  const auto loss = [&] {
    const std::vector<VolumeLightd> light = reference_emission(e.volume(), rays);
    double sum = 0;
    for (size_t i = 0; i < light.size(); ++i)
      sum += dot(weights[i].color, light[i].color) + weights[i].transmittance * light[i].transmittance;
    return sum;
  };
  const EmittingGradients grad = reference_emission_vjp(e.volume(), rays, weights);
  std::vector<double> actual = test::flat(grad.gaussians), expected;
  for (Gaussian3d& g : e.set)
    for (double* v = &g.mean.x; v != &g.mean.x + Gaussian3d::kValues; ++v) expected.push_back(finite_difference(*v, loss, 1e-5));
  const GradTolerance tolerance{.relative_l2 = 1e-6, .bias = 1e-6};
  EXPECT_EQ((compare_gradients<double, double>(actual, expected, tolerance).problem(tolerance)), "");
  actual.clear(), expected.clear();
  for (size_t i = 0; i < e.colors.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      actual.push_back(grad.colors[i][c]);
      expected.push_back(finite_difference(e.colors[i][c], loss, 1e-4));
    }
  EXPECT_EQ((compare_gradients<double, double>(actual, expected, tolerance).problem(tolerance)), "");
}

TEST(EmissionReference, CellsAreExactForOneColourAndConvergeForMany) {
  const Emitters e = emitters(30, 2.7, 33);
  const std::vector<VolumeRay> rays = test::cone_rays(8, 8, {}, 4, 1.3);
  const auto even = [](int cells) {
    std::vector<float> nodes;
    for (int k = 1; k < cells; ++k) nodes.push_back(-1.6f + 3.2f * float(k) / float(cells));
    return nodes;
  };
  Emitters one = e;
  for (Vec3d& c : one.colors) c = {0.3, 0.5, 0.8};
  const std::vector<VolumeLightd> exact = reference_emission(one.volume(), rays),
                                  coarse = reference_cells(one.volume(), rays, {}, even(4));
  for (size_t i = 0; i < rays.size(); ++i) EXPECT_NEAR(length(exact[i].color - coarse[i].color), 0, 1e-5);
  const std::vector<VolumeLightd> truth = reference_emission(e.volume(), rays);
  std::vector<double> errors;
  for (const int cells : {32, 64, 128}) {
    const std::vector<VolumeLightd> light = reference_cells(e.volume(), rays, {}, even(cells));
    double& sum = errors.emplace_back();
    for (size_t i = 0; i < rays.size(); ++i) sum += length(light[i].color - truth[i].color) / double(rays.size());
  }
  EXPECT_LT(errors[0], 0.01);
  EXPECT_LT(errors[1], errors[0] / 3);
  EXPECT_LT(errors[2], errors[1] / 3) << "of second order: a quarter";
}

}  // namespace
}  // namespace vitrine
