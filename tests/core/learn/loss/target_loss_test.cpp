// The losses that need a target beside the photo: masks, normals, first hits. Gradients against finite differences, and
// silence without the target.
#include <gtest/gtest.h>

#include "core/learn/loss/loss_set.h"
#include "tests/core/learn/loss/test_frame.h"

namespace vitrine {
namespace {

struct ChannelCase {
  const char* loss;
  Aov channel;
  float h, tolerance;
};
class ChannelLoss : public ::testing::TestWithParam<std::tuple<ChannelCase, bool>> {};

TEST_P(ChannelLoss, GradientMatchesFiniteDifferences) {
  const auto [c, weighted] = GetParam();
  TestFrame frame(11, 7, weighted);
  const auto loss = make(c.loss);
  LossGradient gradient = frame.gradient();
  loss->evaluate(frame.input(), 1, gradient);
  const RasterImages expected = frame.grad_raster;
  const Agreement a = check(*loss, frame, frame.raster.plane(c.channel), expected.plane(c.channel), c.h);
  EXPECT_GT(a.norm, 0);
  EXPECT_LT(a.worst, c.tolerance);
  for (const AovRow& r : kAovs) {
    if (r.id == c.channel) continue;
    for (float g : expected.plane(r.id)) ASSERT_EQ(g, 0) << r.name;
  }
}
INSTANTIATE_TEST_SUITE_P(Targets, ChannelLoss,
                         ::testing::Combine(::testing::Values(ChannelCase{"specular_mask", Aov::SpecularWeight, 1e-2f, 1e-4f},
                                                              ChannelCase{"transmission_mask", Aov::Transmission, 1e-4f, 1e-2f},
                                                              ChannelCase{"object_mask", Aov::Alpha, 1e-3f, 1e-2f},
                                                              ChannelCase{"monocular_normal", Aov::Normal, 1e-3f, 2e-3f}),
                                            ::testing::Bool()),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param).loss) + (std::get<1>(info.param) ? "_weighted" : "");
                         });

TEST(MonocularNormal, IsZeroWhereTheRenderedNormalIsTheTarget) {
  TestFrame frame(12, 10, false);
  const size_t n = 120;
  const Vec3d towards = normalized(Vec3d{0.3, -0.2, -1.0}), in_world = transposed(frame.view.cam_from_world.rotation) * towards;
  for (size_t i = 0; i < n; ++i)
    for (size_t c = 0; c < 3; ++c) {
      frame.normals[c * n + i] = float(towards[c]);
      frame.raster.plane(Aov::Normal)[c * n + i] = 0.7f * float(in_world[c]);
    }
  LossGradient g = frame.gradient();
  EXPECT_NEAR(make("monocular_normal")->evaluate(frame.input(), 1, g), 0, 1e-6);
}

TEST(MaskCrossEntropy, PullsWithFiniteForceAtTheEnds) {
  TestFrame frame(8, 6, false);
  for (size_t i = 0; i < 48; ++i) {
    frame.transparent[i] = i % 2 == 0 ? 1.f : 0.f;
    frame.raster.plane(Aov::Transmission)[i] = i % 2 == 0 ? 0.f : 1.f;  // the worst possible answer
  }
  LossGradient g = frame.gradient();
  EXPECT_TRUE(std::isfinite(make("transmission_mask")->evaluate(frame.input(), 48, g)));
  for (size_t i = 0; i < 48; ++i) {
    const float pull = frame.grad_raster.plane(Aov::Transmission)[i];
    EXPECT_NEAR(pull, i % 2 == 0 ? -100.f : 100.f, 1e-2f);
  }
}

TEST(SpecularMask, IsContentWithMoreThanTheTargetInside) {
  TestFrame frame(8, 6, false);
  std::fill(frame.specular.begin(), frame.specular.end(), 1.f);
  std::ranges::fill(frame.raster.plane(Aov::SpecularWeight), 0.8f);
  LossGradient g = frame.gradient();
  EXPECT_EQ(make("specular_mask")->evaluate(frame.input(), 1, g), 0);
  for (float v : frame.grad_raster.plane(Aov::SpecularWeight)) EXPECT_EQ(v, 0);
}

class FirstHit : public ::testing::TestWithParam<bool> {};
TEST_P(FirstHit, GradientMatchesFiniteDifferences) {
  TestFrame frame(4, 4, GetParam());
  const auto loss = make("first_hit");
  LossGradient gradient = frame.gradient();
  loss->evaluate(frame.input(), 1, gradient);
  for (TestFrame::Rays* rays : {&frame.reflection, &frame.transmission}) {
    std::vector<float> expected;
    // A ray that met nothing has no first hit to move: the loss is not defined beside 0.
    for (size_t i = 0; i < rays->first_hit.size(); ++i) {
      if (rays->first_hit[i] > 0) continue;
      EXPECT_EQ(rays->grad[i], 0);
      rays->first_hit[i] = 0.5f, rays->alpha[i] = 0;
    }
    expected = rays->grad;
    const Agreement a = check(*loss, frame, rays->first_hit, expected, 1e-3f);
    EXPECT_GT(a.norm, 0);
    EXPECT_LT(a.worst, 2e-3);
  }
}
INSTANTIATE_TEST_SUITE_P(Weighted, FirstHit, ::testing::Bool());

TEST(FirstHit, ALayerThatStaysBehindItsWallAndIsCompactCostsNothing) {
  TestFrame frame(4, 4, false);
  for (TestFrame::Rays* rays : {&frame.reflection, &frame.transmission})
    for (size_t i = 0; i < rays->first_hit.size(); ++i) rays->mean_distance[i] = rays->first_hit[i] = 2.5f;
  LossGradient g = frame.gradient();
  EXPECT_EQ(make("first_hit")->evaluate(frame.input(), 1, g), 0);
}

// No target, no value, no gradient: also when the diffuse pass blends no materials.
TEST(Targets, LossesWithoutTheirTargetAreSilent) {
  for (const char* name : {"specular_mask", "transmission_mask", "object_mask", "first_hit", "monocular_normal"}) {
    TestFrame frame(9, 7, true);
    LossInput input = frame.input();
    input.targets = {};
    input.reflection = input.transmission = {};
    LossGradient g = frame.gradient();
    EXPECT_EQ(make(name)->evaluate(input, 1, g), 0) << name;
    for (const AovRow& r : kAovs)
      for (float v : frame.grad_raster.plane(r.id)) ASSERT_EQ(v, 0) << name;
  }
  for (const char* name : {"specular_mask", "transmission_mask"}) {
    TestFrame frame(9, 7, true);
    for (Aov a : {Aov::SpecularWeight, Aov::Transmission}) frame.raster.planes[size_t(a)].clear();
    LossGradient g = frame.gradient();
    EXPECT_EQ(make(name)->evaluate(frame.input(), 1, g), 0) << name;
  }
}

// How much glass reflects is Fresnel's law and no matter of masks, whether the specular mask includes it or not.
TEST(Targets, TheSpecularMaskHasNoSayOnGlass) {
  TestFrame frame(10, 8, false);
  std::fill(frame.transparent.begin(), frame.transparent.begin() + 40, 1.f);
  std::fill(frame.transparent.begin() + 40, frame.transparent.end(), 0.f);
  LossGradient g = frame.gradient();
  const auto loss = make("specular_mask");
  const double with_glass = loss->evaluate(frame.input(), 1, g);
  const auto grad = frame.grad_raster.plane(Aov::SpecularWeight);
  for (size_t i = 0; i < 40; ++i) ASSERT_EQ(grad[i], 0) << i;
  EXPECT_TRUE(std::any_of(grad.begin() + 40, grad.end(), [](float v) { return v != 0; }));
  for (size_t i = 0; i < 40; ++i) frame.specular[i] = 1 - frame.specular[i];
  g = frame.gradient();
  EXPECT_EQ(loss->evaluate(frame.input(), 1, g), with_glass);
}

// A coat reflects by Fresnel's law: neither is it pulled to the specular weight of a mirror nor to zero.
TEST(Targets, TheSpecularMaskHasNoSayOnACoat) {
  TestFrame frame(10, 8, false);
  frame.transparent.clear();
  std::vector<float> coat(80, 0.f);
  std::fill(coat.begin(), coat.begin() + 40, 1.f);
  LossInput input = frame.input();
  input.targets.coat = coat;
  LossGradient g = frame.gradient();
  make("specular_mask")->evaluate(input, 1, g);
  const auto grad = frame.grad_raster.plane(Aov::SpecularWeight);
  for (size_t i = 0; i < 40; ++i) ASSERT_EQ(grad[i], 0) << i;
  EXPECT_TRUE(std::any_of(grad.begin() + 40, grad.end(), [](float v) { return v != 0; }));
}

// Ignored pixels have no say, and do not thin the others out.
TEST(Targets, IgnoredPixelsHaveNoSay) {
  for (const char* name : {"specular_mask", "transmission_mask", "object_mask"}) {
    TestFrame frame(10, 8, false), half(10, 4, false);
    frame.ignore.assign(80, 0.f);
    std::fill(frame.ignore.begin() + 40, frame.ignore.end(), 1.f);
    const auto copy = [](std::span<const float> from, std::span<float> to) { std::copy_n(from.begin(), to.size(), to.begin()); };
    copy(frame.specular, half.specular), copy(frame.transparent, half.transparent), copy(frame.object, half.object);
    for (Aov a : {Aov::SpecularWeight, Aov::Transmission, Aov::Alpha}) copy(frame.raster.plane(a), half.raster.plane(a));
    LossGradient g = frame.gradient(), gh = half.gradient();
    const auto loss = make(name);
    EXPECT_NEAR(loss->evaluate(frame.input(), 1, g), loss->evaluate(half.input(), 1, gh), 1e-9) << name;
  }
}

}  // namespace
}  // namespace vitrine
