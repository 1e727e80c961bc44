// The fast path of emission and absorption against the cells of the reference and against the integral itself.
#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/render/volume/emission_absorption.h"
#include "core/render/volume/reference/reference.h"
#include "tests/core/render/volume/gaussian_sets.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

struct EmissionScene {
  static constexpr int kWidth = 45, kHeight = 21;  // no multiples of a tile
  static constexpr Vec3d kCentre{12, -7, 3};

  explicit EmissionScene(size_t count, double log_density, double log_scale = 0)
      : set(test::random_gaussians(count, kCentre, 41)) {
    for (size_t i = 0; i < count; ++i) {
      set[i].log_density += log_density;
      set[i].log_scale += Vec3d{log_scale, log_scale, log_scale};
      set[i] = cast<double>(cast<float>(set[i]));
      Rng rng(42, i);
      fast_colors.push_back({rng.uniform(), rng.uniform(), rng.uniform()});
      colors.push_back(cast<double>(fast_colors.back()));
    }
    fast = test::floats(set);
  }
  std::vector<Gaussian3d> set;
  std::vector<Gaussian3f> fast;
  std::vector<Vec3d> colors;
  std::vector<Vec3f> fast_colors;
  std::vector<VolumeRay> rays = test::cone_rays(kWidth, kHeight, kCentre, 6, 1.1);
  RayTiles tiles{rays, kWidth, kCentre};
  EmittingGaussians volume() const { return {set, colors}; }

  // Rays of a tile inside the picture.
  std::vector<size_t> pixels(const RayTiles::Tile& tile) const {
    std::vector<size_t> out;
    for (int i = 0; i < RayTiles::kRays; ++i) {
      const int x = tile.x + i % RayTiles::kSide, y = tile.y + i / RayTiles::kSide;
      if (x < kWidth && y < kHeight) out.push_back(size_t(y * kWidth + x));
    }
    return out;
  }
  // With the cells of the fast path.
  std::vector<VolumeLightd> by_cells(const EmissionAbsorption& path) const {
    std::vector<VolumeLightd> out(rays.size());
    for (size_t t = 0; t < tiles.tiles().size(); ++t) {
      const std::vector<size_t> of_tile = pixels(tiles.tiles()[t]);
      std::vector<VolumeRay> some;
      for (const size_t pixel : of_tile) some.push_back(rays[pixel]);
      const std::vector<VolumeLightd> light = reference_cells(volume(), some, kCentre, path.nodes(t));
      for (size_t i = 0; i < some.size(); ++i) out[of_tile[i]] = light[i];
    }
    return out;
  }
};

double distance(const VolumeLightf& a, const VolumeLightd& b) {
  return std::max(length(cast<double>(a.color) - b.color), std::abs(double(a.transmittance) - b.transmittance));
}

std::vector<VolumeLightf> weights_of(size_t count) {
  std::vector<VolumeLightf> out;
  for (size_t i = 0; i < count; ++i) {
    Rng rng(6, i);
    out.push_back({{rng.normal(), rng.normal(), rng.normal()}, rng.normal()});
  }
  return out;
}

// Values of one kind of all Gaussians: lengths differ between kinds.
std::vector<double> every(const std::vector<double>& values, size_t first) {
  std::vector<double> out;
  for (size_t i = first; i < values.size(); i += Gaussian3d::kValues) out.push_back(values[i]);
  return out;
}

TEST(EmissionAbsorption, IsThatOfTheSameCells) {
  for (const double log_density : {-1., 3.}) {
    const EmissionScene s(120, log_density);
    const EmissionAbsorption path(s.tiles, s.fast, 24, 12);
    std::vector<VolumeLightf> light(s.rays.size());
    path.forward(s.fast_colors, light);
    const std::vector<VolumeLightd> expected = s.by_cells(path);
    double least = 1;
    for (size_t i = 0; i < light.size(); ++i) {
      ASSERT_LT(distance(light[i], expected[i]), 3e-4) << i;  // Gaussians end at 4 standard deviations along the ray
      least = std::min(least, expected[i].transmittance);
    }
    EXPECT_LT(least, log_density > 0 ? 1e-3 : 0.8);
  }
}

TEST(EmissionAbsorption, ComesCloseToTheIntegral) {
  struct Case {
    size_t count;
    double log_density, log_scale, mean;
  };
  for (const Case& c : {Case{120, -1, 0, 1e-3}, Case{120, 3, 0, 1e-3}, Case{12, 1.5, 1.2, 1e-3}, Case{400, 3, -0.6, 2e-3}}) {
    const EmissionScene s(c.count, c.log_density, c.log_scale);
    std::vector<VolumeLightf> light(s.rays.size());
    EmissionAbsorption(s.tiles, s.fast).forward(s.fast_colors, light);
    std::vector<VolumeRay> some;  // the truth takes time
    std::vector<VolumeLightf> of_some;
    for (size_t i = 0; i < s.rays.size(); i += 37) some.push_back(s.rays[i]), of_some.push_back(light[i]);
    const std::vector<VolumeLightd> truth = reference_emission(s.volume(), some);
    double sum = 0;
    for (size_t i = 0; i < some.size(); ++i) sum += distance(of_some[i], truth[i]) / double(some.size());
    EXPECT_LT(sum, c.mean) << c.count << " Gaussians, " << c.log_density;
  }
}

TEST(EmissionAbsorption, GradientsAreThoseOfTheCells) {
  EmissionScene s(6, 2.5, 0.8);
  const EmissionAbsorption path(s.tiles, s.fast, 24, 12);
  const std::vector<VolumeLightf> weights = weights_of(s.rays.size());
  std::vector<Gaussian3Gradient> out(s.fast.size());
  std::vector<Vec3f> out_colors(s.fast.size());
  path.backward(s.fast_colors, weights, out, out_colors);
  const auto loss = [&] {
    const std::vector<VolumeLightd> light = s.by_cells(path);
    double sum = 0;
    for (size_t i = 0; i < light.size(); ++i)
      sum += dot(cast<double>(weights[i].color), light[i].color) + double(weights[i].transmittance) * light[i].transmittance;
    return sum;
  };
  std::vector<double> expected, actual_colors, expected_colors;
  for (Gaussian3d& g : s.set)
    for (double* v = &g.mean.x; v != &g.mean.x + Gaussian3d::kValues; ++v) expected.push_back(finite_difference(*v, loss, 1e-5));
  for (size_t i = 0; i < s.colors.size(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      actual_colors.push_back(double(out_colors[i][c]));
      expected_colors.push_back(finite_difference(s.colors[i][c], loss, 1e-4));
    }
  const GradTolerance tolerance{.relative_l2 = 1e-3, .bias = 1e-3};
  const std::vector<double> actual = test::flat(out);
  for (size_t v = 0; v < Gaussian3d::kValues; ++v)
    expect_grad_close(every(actual, v), every(expected, v), tolerance, "value " + std::to_string(v));
  expect_grad_close(actual_colors, expected_colors, tolerance, "colours");
}

TEST(EmissionAbsorption, GradientsComeCloseToThoseOfTheIntegral) {
  const EmissionScene s(12, 2.5, 0.6);
  const std::vector<VolumeLightf> weights = weights_of(s.rays.size());
  std::vector<VolumeLightd> exact_weights;
  for (const VolumeLightf& w : weights) exact_weights.push_back({cast<double>(w.color), double(w.transmittance)});
  const EmittingGradients truth = reference_emission_vjp(s.volume(), s.rays, exact_weights);
  std::vector<double> errors;
  for (const int cells : {16, 32, 64}) {
    std::vector<Gaussian3Gradient> out(s.fast.size());
    std::vector<Vec3f> out_colors(s.fast.size());
    EmissionAbsorption(s.tiles, s.fast, cells).backward(s.fast_colors, weights, out, out_colors);
    const std::vector<double> actual = test::flat(out), expected = test::flat(truth.gaussians);
    double& worst = errors.emplace_back();
    for (size_t v = 0; v < Gaussian3d::kValues; ++v)
      worst = std::max(worst, compare_gradients<double, double>(every(actual, v), every(expected, v), {}).relative_l2);
  }
  EXPECT_LT(errors[1], errors[0]);
  EXPECT_LT(errors[1], 0.03);
  EXPECT_LT(errors[2], 0.01);
}

TEST(EmissionAbsorption, SameBytesForAnyNumberOfThreads) {
  const EmissionScene s(100, 2);
  const std::vector<VolumeLightf> weights = weights_of(s.rays.size());
  std::vector<std::vector<VolumeLightf>> lights;
  std::vector<std::vector<Gaussian3Gradient>> gradients;
  std::vector<std::vector<Vec3f>> of_colors;
  for (const int threads : {1, 2, 5}) {
    set_thread_limit(threads);
    const EmissionAbsorption path(s.tiles, s.fast);
    path.forward(s.fast_colors, lights.emplace_back(s.rays.size()));
    path.backward(s.fast_colors, weights, gradients.emplace_back(s.fast.size()), of_colors.emplace_back(s.fast.size()));
  }
  set_thread_limit(0);
  for (size_t i = 1; i < lights.size(); ++i)
    EXPECT_TRUE(lights[0] == lights[i] && gradients[0] == gradients[i] && of_colors[0] == of_colors[i]);
}

TEST(EmissionAbsorption, GaussiansThatAreNotSeenMoveNoCells) {
  EmissionScene s(30, 1);
  const EmissionAbsorption before(s.tiles, s.fast);
  for (const float log_density : {-30.f, -300.f}) {  // the second is 0 as a float
    s.fast.push_back({.mean = cast<float>(EmissionScene::kCentre + 500.0 * s.rays[s.rays.size() / 2].direction),
                      .log_scale = {4, 4, 4},
                      .rotation = {1, 0, 0, 0},
                      .log_density = log_density});
    s.fast_colors.push_back({1, 1, 1});
  }
  const EmissionAbsorption path(s.tiles, s.fast);
  EXPECT_GE(path.instances(), before.instances() + 2 * s.tiles.tiles().size()) << "they are in no tile";
  const size_t middle = s.tiles.tiles().size() / 2;  // a tile that others fill
  EXPECT_TRUE(std::ranges::equal(before.nodes(middle), path.nodes(middle)));
  std::vector<VolumeLightf> light(s.rays.size());
  path.forward(s.fast_colors, light);
  for (const VolumeLightf& l : light) ASSERT_TRUE(std::isfinite(l.color.x + l.transmittance));
  std::vector<Gaussian3Gradient> out(s.fast.size());
  std::vector<Vec3f> out_colors(s.fast.size());
  path.backward(s.fast_colors, weights_of(s.rays.size()), out, out_colors);
  for (const double v : test::flat(out)) ASSERT_TRUE(std::isfinite(v));
}

TEST(EmissionAbsorption, RaysThatMeetNothingAreClear) {
  const EmissionScene s(3, 1);
  std::vector<Gaussian3f> away = s.fast;
  for (Gaussian3f& g : away) g.mean += Vec3f{100, 0, 0};
  std::vector<VolumeLightf> light(s.rays.size());
  const EmissionAbsorption path(s.tiles, away);
  EXPECT_EQ(path.instances(), 0u);
  path.forward(s.fast_colors, light);
  for (const VolumeLightf& l : light) EXPECT_EQ(l, (VolumeLightf{{}, 1.f}));
  EXPECT_THROW(EmissionAbsorption(s.tiles, s.fast, 1), Error);
  EXPECT_THROW(path.forward(s.fast_colors, std::span(light).first(3)), Error);
}

}  // namespace
}  // namespace vitrine
