// Water and haze in front of the picture: the kernel against dual numbers, the pass against finite differences and against the
// formula at known distances.
#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/dual.h"
#include "core/render/model/kernels/medium.h"
#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/tiny_rooms.h"

namespace vitrine {
namespace {

const MediumCoefficients<double> kWater{{0.5, 0.2, 0.1}, {0.4, 0.25, 0.15}, {0.1, 0.3, 0.45}};

TEST(MediumKernel, MatchesDualNumbers) {
  using N = Dual<double, 6>;
  for (uint64_t seed = 0; seed < 40; ++seed) {
    Rng rng(seed, 7);
    const double x[] = {rng.uniform_double(), 3 * rng.uniform_double(), rng.uniform_double(),
                        rng.uniform_double(), rng.uniform_double(),     rng.uniform_double()};
    const double g = rng.uniform_double() - 0.5;
    std::array<N, 6> v;
    for (size_t i = 0; i < 6; ++i) v[i] = N::variable(x[i], i);
    const N exact = N(g) * seen_through_medium(v[0], v[1], v[2], v[3], v[4], v[5]);
    const MediumGradient<double> a = seen_through_medium_vjp(x[0], x[1], x[2], x[3], x[4], x[5], g);
    const double got[] = {a.clear, a.distance, a.coverage, a.direct, a.backscatter, a.veil};
    for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(got[i], exact.d[i], 1e-12) << seed << " " << i;
  }
}

TEST(MediumKernel, IsThePublishedFormulaOnSurfacesAndTheVeilWhereThereIsNone) {
  EXPECT_NEAR(seen_through_medium(0.8, 2.0, 1.0, 0.3, 0.4, 0.25), 0.8 * std::exp(-0.6) + 0.25 * (1 - std::exp(-0.8)), 1e-15);
  EXPECT_EQ(seen_through_medium(0.0, 0.0, 0.0, 0.3, 0.4, 0.25), 0.25);
  const Vec3d clear{0.8, 0.3, 0.05};
  Vec3d seen;
  for (size_t c = 0; c < 3; ++c)
    seen[c] = seen_through_medium(clear[c], 2.0, 1.0, kWater.direct[c], kWater.backscatter[c], kWater.veil[c]);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(without_medium(kWater, seen, 2.0)[c], clear[c], 1e-12);
  EXPECT_EQ(without_medium(kWater, Vec3d{}, 2.0), Vec3d{}) << "no radiance below zero";
  EXPECT_LT(without_medium(kWater, Vec3d{0.5, 0.5, 0.5}, 1e3).x, 20) << "noise is not amplified without bound";
}

struct SeenRoom {
  LayeredRoom room = furnished_room({}, 5, 13, 11);
  ImageOptions options = exact_options();
  Frame frame;
  SeenRoom() { options.medium = kWater; }
  const Frame& forward() {
    LayeredModel(options).forward(room.scene, room.view, frame);
    return frame;
  }
};

TEST(MediumPass, ShowsTheFormulaAtTheMeanDistanceAndKeepsTheClearPicture) {
  SeenRoom seen;
  const Frame& frame = seen.forward();
  ImageOptions in_air = seen.options;
  in_air.medium.reset();
  Frame air;
  LayeredModel(in_air).forward(seen.room.scene, seen.room.view, air);
  EXPECT_TRUE(air.clear.empty());
  EXPECT_EQ(frame.clear, air.linear);
  const size_t pixels = frame.pixel_count();
  for (const size_t i : {size_t{0}, pixels / 2, pixels - 1}) {
    const double a = double(frame.diffuse.plane(Aov::Alpha)[i]);
    const Vec3d ray = seen.room.view.intrinsics.ray(double(i % 13) + 0.5, double(i / 13) + 0.5);
    const double z = length(ray) * double(frame.diffuse.plane(Aov::ZDepth)[i]) / a;
    EXPECT_GT(z, 1);
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(double(frame.linear[c * pixels + i]),
                  double(air.linear[c * pixels + i]) * std::exp(-kWater.direct[c] * z) +
                      kWater.veil[c] * (1 - a * std::exp(-kWater.backscatter[c] * z)),
                  1e-6);
  }
}

TEST(MediumPass, AMediumWithoutScatteringOrAbsorptionChangesNothing) {
  SeenRoom seen;
  seen.options.medium = MediumCoefficients<double>{{}, {}, {}};
  const Frame& frame = seen.forward();
  EXPECT_EQ(frame.linear, frame.clear);
}

TEST(MediumPass, GradientsOfTheSurfelsMatchFiniteDifferences) {
  SeenRoom seen;
  LayeredModel model(seen.options);
  Frame frame;
  const auto loss = [&] {
    model.forward(seen.room.scene, seen.room.view, frame);
    return loss_of(frame);
  };
  loss();
  start_gradient(frame);
  SplatScene grad = seen.room.scene.zeros_like();
  model.backward(seen.room.scene, frame, grad);
  for (const Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::Opacity, Attribute::ShDc})
    expect_differences(seen.room.scene, grad, LayerKind::Diffuse, a, loss);
  expect_differences(seen.room.scene, grad, LayerKind::Transmittance, Attribute::ShDc, loss);
}

// A frame filled by hand: the pass alone, every input against central differences.
struct FilledFrame {
  View view;
  Frame frame;
  std::vector<float> clear, weights;  // [3,h,w] J, dL/dI
  FilledFrame() {
    view.intrinsics = {7, 5, 6, 6.5, 3.4, 2.6};
    frame.view = &view;
    frame.options.medium = kWater;
    const size_t pixels = frame.pixel_count();
    Rng rng(11, 3);
    for (const Aov a : {Aov::ZDepth, Aov::Alpha}) {
      frame.diffuse.planes[size_t(a)].resize(pixels);
      frame.grad_diffuse.planes[size_t(a)].resize(pixels);
    }
    for (size_t i = 0; i < pixels; ++i) {
      const float alpha = i % 7 == 3 ? 0.f : 0.2f + 0.8f * rng.uniform();
      frame.diffuse.plane(Aov::Alpha)[i] = alpha;
      frame.diffuse.plane(Aov::ZDepth)[i] = alpha * (0.5f + 2 * rng.uniform());
    }
    for (size_t i = 0; i < 3 * pixels; ++i) clear.push_back(rng.uniform()), weights.push_back(rng.uniform() - 0.3f);
  }
  double loss() {
    frame.linear = clear;
    MediumPass().forward({}, frame);
    double sum = 0;
    for (size_t i = 0; i < clear.size(); ++i) sum += double(weights[i]) * double(frame.linear[i]);
    return sum;
  }
};

TEST(MediumPass, EveryGradientMatchesFiniteDifferences) {
  FilledFrame f;
  f.loss();
  f.frame.grad_linear = f.weights;
  MediumPass pass;
  SplatScene grad;
  pass.backward({}, f.frame, grad);
  const GradTolerance tolerance{.relative_l2 = 2e-3, .bias = 2e-3};
  const auto loss = [&] { return f.loss(); };
  const std::vector<float> on_clear = f.frame.grad_linear;
  expect_grad_close(on_clear, extrapolated_differences(f.clear, loss), tolerance, "radiance");
  for (const Aov a : {Aov::ZDepth, Aov::Alpha}) {
    const auto plane = f.frame.grad_diffuse.plane(a);
    std::vector<float> actual;
    std::vector<double> expected;
    for (size_t i = 0; i < f.frame.pixel_count(); ++i) {
      if (f.frame.diffuse.plane(Aov::Alpha)[i] == 0) continue;
      actual.push_back(plane[i]);
      expected.push_back(extrapolated_differences(f.frame.diffuse.plane(a).subspan(i, 1), loss)[0]);
    }
    expect_grad_close(actual, expected, tolerance, a == Aov::Alpha ? "alpha" : "depth");
  }
  std::vector<double> got, expected;
  for (const auto row :
       {&MediumCoefficients<double>::direct, &MediumCoefficients<double>::backscatter, &MediumCoefficients<double>::veil})
    for (size_t c = 0; c < 3; ++c) {
      got.push_back((pass.gradient().*row)[c]);
      expected.push_back(finite_difference(((*f.frame.options.medium).*row)[c], loss, 1e-2));
    }
  expect_grad_close(got, expected, tolerance, "coefficients");
}

TEST(MediumPass, IsTheSameForAnyNumberOfThreads) {
  SeenRoom seen;
  seen.options.diffuse.backend = Backend::Cpu;
  expect_same_for_threads(seen.options, seen.room.scene, seen.room.view);
}

}  // namespace
}  // namespace vitrine
