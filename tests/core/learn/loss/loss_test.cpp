// Every loss of the registry against finite differences, over frames of odd sizes, with and without weights; the pointwise
// kernels against dual numbers; the structural similarity against a plain two-dimensional one.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/learn/loss/loss_set.h"
#include "core/learn/loss/normal_kernel.h"
#include "core/learn/loss/ssim_kernel.h"
#include "core/foundation/math/dual.h"
#include "tests/core/learn/loss/test_frame.h"

namespace vitrine {
namespace {

class PictureLoss : public ::testing::TestWithParam<std::tuple<const char*, int, int, bool>> {};

TEST_P(PictureLoss, GradientMatchesFiniteDifferences) {
  const auto [name, width, height, weighted] = GetParam();
  TestFrame frame(width, height, weighted);
  const auto loss = make(name);
  LossGradient gradient = frame.gradient();
  loss->evaluate(frame.input(), 1, gradient);
  const std::vector<float> expected = frame.grad_prediction;
  const Agreement a = check(*loss, frame, frame.prediction, expected, 1e-3f);
  EXPECT_GT(a.norm, 0);
  EXPECT_LT(a.worst, 5e-3) << name;  // worst seen 1.1e-3: float sums
}
INSTANTIATE_TEST_SUITE_P(Sizes, PictureLoss,
                         ::testing::Combine(::testing::Values("l1", "dssim"), ::testing::Values(5, 8, 13, 24),
                                            ::testing::Values(3, 14), ::testing::Bool()));

double plain_ssim(const TestFrame& frame) {
  const int w = frame.view.intrinsics.width, h = frame.view.intrinsics.height;
  double window[11], sum = 0, total = 0;
  for (int t = 0; t < 11; ++t) sum += window[t] = std::exp(-(t - 5) * (t - 5) / (2 * 1.5 * 1.5));
  for (double& k : window) k /= sum;
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) {
        SsimMoments<double> m{};
        for (int dy = -5; dy <= 5; ++dy)
          for (int dx = -5; dx <= 5; ++dx) {
            if (y + dy < 0 || y + dy >= h || x + dx < 0 || x + dx >= w) continue;
            const size_t i = size_t((c * h + y + dy) * w + x + dx);
            const double k = window[dy + 5] * window[dx + 5], a = frame.prediction[i], b = frame.target[i];
            m.mu_x += k * a, m.mu_y += k * b, m.xx += k * a * a, m.yy += k * b * b, m.xy += k * a * b;
          }
        const double c1 = 1e-4, c2 = 9e-4;
        total += (2 * m.mu_x * m.mu_y + c1) * (2 * (m.xy - m.mu_x * m.mu_y) + c2) /
                 ((m.mu_x * m.mu_x + m.mu_y * m.mu_y + c1) * (m.xx - m.mu_x * m.mu_x + m.yy - m.mu_y * m.mu_y + c2));
      }
  return total / (3.0 * w * h);
}

TEST(Dssim, IsOneMinusThePlainTwoDimensionalSimilarity) {
  for (int width : {6, 21, 32}) {
    TestFrame frame(width, 17, false);
    LossGradient gradient = frame.gradient();
    EXPECT_NEAR(make("dssim")->evaluate(frame.input(), 1, gradient), 1 - plain_ssim(frame), 2e-6);
  }
}

TEST(Dssim, IsZeroAndFlatForEqualPictures) {
  TestFrame frame(20, 15, false);
  frame.target = frame.prediction;
  LossGradient gradient = frame.gradient();
  EXPECT_NEAR(make("dssim")->evaluate(frame.input(), 1, gradient), 0, 1e-6);
  for (float g : frame.grad_prediction) EXPECT_NEAR(g, 0, 1e-5);
}

TEST(SsimPoint, PartialsMatchDualNumbers) {
  using D = Dual<double, 3>;
  Rng rng(3);
  for (int trial = 0; trial < 100; ++trial) {
    const double mx = rng.uniform_double(), my = rng.uniform_double(), sx = 0.1 * rng.uniform_double(),
                 sy = 0.1 * rng.uniform_double();
    const double sxy = std::sqrt(sx * sy) * (2 * rng.uniform_double() - 1);
    const SsimMoments<double> m{mx, my, sx + mx * mx, sy + my * my, sxy + mx * my};
    const SsimPoint<double> p = ssim_point(m);
    const SsimPoint<D> d =
        ssim_point<D>({D::variable(m.mu_x, 0), D(m.mu_y), D::variable(m.xx, 1), D(m.yy), D::variable(m.xy, 2)});
    EXPECT_NEAR(d.value.v, p.value, 1e-12);
    const double partials[] = {p.grad_mu_x, p.grad_xx, p.grad_xy};
    for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(d.value.d[k], partials[k], 1e-9 * (1 + std::abs(partials[k])));
  }
}

TEST(NormalTerm, GradientMatchesDualNumbers) {
  using D = Dual<double, 9>;
  Rng rng(5);
  for (int trial = 0; trial < 100; ++trial) {
    Vec3d v[3];
    Vec3<D> dv[3];
    for (size_t k = 0; k < 9; ++k) {
      v[k / 3][k % 3] = rng.normal();
      dv[k / 3][k % 3] = D::variable(v[k / 3][k % 3], k);
    }
    const double alpha = rng.uniform_double();
    const auto term = normal_term<double>(v[0], v[1], v[2], alpha);
    const auto dual = normal_term<D>(dv[0], dv[1], dv[2], D(alpha));
    EXPECT_NEAR(dual.value.v, term.value, 1e-12);
    const Vec3d* gradients[] = {&term.grad_normal, &term.grad_a, &term.grad_b};
    for (size_t k = 0; k < 9; ++k)
      EXPECT_NEAR(dual.value.d[k], (*gradients[k / 3])[k % 3], 1e-9 * (1 + std::abs(dual.value.d[k])));
  }
}

TEST(NormalConsistency, GradientMatchesFiniteDifferences) {
  TestFrame frame(9, 7, false);
  const auto loss = make("normal_consistency");
  LossGradient gradient = frame.gradient();
  loss->evaluate(frame.input(), 1, gradient);
  const RasterImages expected = frame.grad_raster;
  const auto agreement = [&](Aov a, float h) { return check(*loss, frame, frame.raster.plane(a), expected.plane(a), h); };
  EXPECT_LT(agreement(Aov::Normal, 1e-2f).worst, 2e-3);
  const Agreement z = agreement(Aov::ZDepth, 1e-3f);
  EXPECT_LT(z.worst, 2e-2);  // the difference quotient's own curvature
  EXPECT_GT(z.norm, 0);
  // The alpha of the weight is held constant; through the depth Z/A it acts like -z times the gradient of Z.
  const size_t pixels = frame.raster.plane(Aov::Alpha).size();
  for (size_t i = 0; i < pixels; ++i) {
    const float depth = frame.raster.plane(Aov::ZDepth)[i] / frame.raster.plane(Aov::Alpha)[i];
    EXPECT_NEAR(expected.plane(Aov::Alpha)[i], -depth * expected.plane(Aov::ZDepth)[i], 1e-6);
  }
}

TEST(NormalConsistencyLoss, VanishesOnAPlaneWithItsOwnNormal) {
  TestFrame frame(12, 10, false);
  const size_t pixels = 120;
  const Vec3d n = normalized(Vec3d{0.3, -0.2, -1.0}), n_world = transposed(frame.view.cam_from_world.rotation) * n;
  for (size_t i = 0; i < pixels; ++i) {
    const Vec3d ray = frame.view.intrinsics.ray(double(i % 12) + 0.5, double(i / 12) + 0.5);
    frame.raster.plane(Aov::Alpha)[i] = 1;
    frame.raster.plane(Aov::ZDepth)[i] = static_cast<float>(dot(n, Vec3d{0, 0, 2}) / dot(n, ray));
    for (size_t c = 0; c < 3; ++c) frame.raster.plane(Aov::Normal)[c * pixels + i] = static_cast<float>(n_world[c]);
  }
  LossGradient gradient = frame.gradient();
  EXPECT_NEAR(make("normal_consistency")->evaluate(frame.input(), 1, gradient), 0, 1e-5);
}

TEST(Distortion, GradientMatchesFiniteDifferences) {
  TestFrame frame(9, 7, false);
  const auto loss = make("distortion");
  LossGradient gradient = frame.gradient();
  loss->evaluate(frame.input(), 1, gradient);
  const RasterImages expected = frame.grad_raster;
  EXPECT_LT(check(*loss, frame, frame.raster.plane(Aov::Distortion), expected.plane(Aov::Distortion), 1e-2f).worst, 1e-3);
}

TEST(SurfelRegularisers, GradientsMatchFiniteDifferences) {
  for (const auto& [name, attribute] : {std::pair{"opacity", Attribute::Opacity}, std::pair{"scale", Attribute::LogScale}}) {
    TestFrame frame(4, 4, false);
    const auto loss = make(name);
    LossGradient gradient = frame.gradient();
    loss->evaluate(frame.input(), 1, gradient);
    const SplatLayer expected = frame.grad_layer;
    const Agreement a = check(*loss, frame, frame.layer.values(attribute), expected.values(attribute), 1e-2f);
    EXPECT_GT(a.norm, 0);
    EXPECT_LT(a.worst, 1e-3) << name;
  }
}

// Each loss keeps its promise about `scale` and about adding to what is there.
TEST(Registry, GradientsScaleAndAccumulate) {
  for (const LossFactory& factory : loss_registry()) {
    TestFrame once(13, 11, false), thrice(13, 11, false);
    const auto loss = factory.make();
    EXPECT_EQ(loss->name(), factory.name);
    LossGradient g1 = once.gradient(), g3 = thrice.gradient();
    const double value = loss->evaluate(once.input(), 3, g1);
    for (int i = 0; i < 3; ++i) EXPECT_EQ(loss->evaluate(thrice.input(), 1, g3), value) << factory.name;
    const auto compare = [&](std::span<const float> a, std::span<const float> b) {
      for (size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5f * std::abs(a[i]) + 1e-8f) << factory.name;
    };
    compare(once.grad_prediction, thrice.grad_prediction);
    for (const AovRow& r : kAovs) compare(once.grad_raster.plane(r.id), thrice.grad_raster.plane(r.id));
    for (const AttributeRow& r : kAttributes) compare(once.grad_layer.values(r.id), thrice.grad_layer.values(r.id));
    compare(once.reflection.grad, thrice.reflection.grad);
    compare(once.transmission.grad, thrice.transmission.grad);
  }
}

TEST(Registry, SameBitsForAnyNumberOfThreads) {
  const auto run = [](int threads) {
    set_thread_limit(threads);
    TestFrame frame(61, 47, true);
    LossSet losses;
    for (LossTerm& term : losses.terms()) term.schedule = {.weight = 1};
    LossGradient gradient = frame.gradient();
    const LossValues values = losses.evaluate(0.5, frame.input(), gradient);
    set_thread_limit(0);
    return std::tuple(values.total, values.terms, frame.grad_prediction, frame.grad_raster.planes, frame.grad_layer,
                      frame.reflection.grad, frame.transmission.grad);
  };
  EXPECT_EQ(run(1), run(2));
  EXPECT_EQ(run(1), run(5));
}

TEST(WeightSchedule, RisesAndStays) {
  const WeightSchedule s{.weight = 2, .from = 0.2, .ramp = 0.1};
  EXPECT_EQ(s.at(0.1), 0);
  EXPECT_FLOAT_EQ(s.at(0.25), 1);
  EXPECT_FLOAT_EQ(s.at(0.5), 2);
  EXPECT_FLOAT_EQ(s.at(1), 2);
}

TEST(WeightSchedule, FallsAlongACosineToItsFinalShare) {
  const WeightSchedule s{.weight = 2, .from = 0.2, .ramp = 0.1, .final_share = 0.25};
  EXPECT_FLOAT_EQ(s.at(0.25), 1);
  EXPECT_FLOAT_EQ(s.at(0.3), 2);
  EXPECT_FLOAT_EQ(s.at(0.65), 2 * (0.25f + 0.75f / 2));
  EXPECT_FLOAT_EQ(s.at(1), 0.5f);
}

TEST(LossSet, DescribesTheWeightOfEveryLoss) {
  LossSet losses;
  OptionTable table = options_of(losses);
  for (const LossFactory& f : loss_registry()) EXPECT_NE(table.find(f.name), nullptr) << f.name;
  EXPECT_NE(table.find("vgg"), nullptr);
  table.find("l1")->assign("0.25", "test");
  EXPECT_EQ(losses.term("l1").schedule.weight, 0.25f);
}

TEST(LossSet, ACopyHasItsWeightsAndOptions) {
  LossSet losses;
  OptionTable table = options_of(losses);
  table.find("l1")->assign("0.25", "test");
  table.find("vgg")->assign("vgg16.safetensors", "test");
  losses.term("dssim").schedule.from = 0.5;
  LossSet copy = losses;
  EXPECT_EQ(options_of(copy).canonical_text(), table.canonical_text());
  EXPECT_EQ(copy.term("dssim").schedule.from, 0.5);
  copy.term("l1").schedule.weight = 1;
  EXPECT_EQ(losses.term("l1").schedule.weight, 0.25f);
}

}  // namespace
}  // namespace vitrine
