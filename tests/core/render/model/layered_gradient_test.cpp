// The gradients of the model with three layers: right, unbiased when rays are drawn, and cut or damped where they are meant to
// be.
#include <gtest/gtest.h>

#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/tiny_rooms.h"

namespace vitrine {
namespace {

const Attribute kAll[] = {Attribute::Mean,           Attribute::Rotation,    Attribute::LogScale, Attribute::Opacity,
                          Attribute::ShDc,           Attribute::ShRest,      Attribute::F0,       Attribute::Roughness,
                          Attribute::SpecularWeight, Attribute::Transmission};

class WholeChain : public testing::TestWithParam<std::tuple<LayerBlend, Lobe>> {};

// Pixel loss -> display -> composite -> rays -> all three layers, against central differences. Every group of parameters on its
// own, so that a large one does not hide a small one.
TEST_P(WholeChain, MatchesFiniteDifferences) {
  ImageOptions options = exact_options();
  std::tie(options.composite.blend, options.reflection.lobe) = GetParam();
  LayeredRoom r = furnished_room({}, 5, 13, 11);
  LayeredModel model(options);
  Frame frame;
  const auto loss = [&] {
    model.forward(r.scene, r.view, frame);
    return loss_of(frame);
  };
  loss();
  ASSERT_EQ(frame.shaded.groups(), frame.pixel_count());
  start_gradient(frame);
  SplatScene grad = r.scene.zeros_like();
  model.backward(r.scene, frame, grad);
  for (LayerKind kind : kAllLayers)
    for (Attribute a : kAll) {
      if (r.scene.layer(kind).values(a).empty() || (a == Attribute::Roughness && options.reflection.lobe == Lobe::Mirror))
        continue;
      expect_differences(r.scene, grad, kind, a, loss);  // worst seen: 6e-3 (scales of the sheets)
    }
}

INSTANTIATE_TEST_SUITE_P(All, WholeChain,
                         testing::Values(std::tuple{LayerBlend::RtrGs, Lobe::Mirror},
                                         std::tuple{LayerBlend::Layered, Lobe::Mirror}));

TEST(LayeredModel, DepthAndNormalGradientsCanBeCut) {
  const LayeredRoom r = furnished_room({}, 5);
  LayeredModel model(exact_options());
  const auto norms = [&] {
    Frame frame;
    model.forward(r.scene, r.view, frame);
    start_gradient(frame);
    SplatScene grad = r.scene.zeros_like();
    model.backward(r.scene, frame, grad);
    const auto norm = [&](Aov a) {
      double sum = 0;
      for (float v : frame.grad_diffuse.plane(a)) sum += std::abs(double(v));
      return sum;
    };
    return std::pair{norm(Aov::Normal), norm(Aov::ZDepth)};
  };
  const auto both = norms();
  EXPECT_GT(both.first, 1e-3);
  EXPECT_GT(both.second, 1e-3);
  model.options().surface.depth_gradient = false;
  EXPECT_EQ(norms().second, 0);
  EXPECT_EQ(norms().first, both.first);
  model.options().surface.normal_gradient = false;
  EXPECT_EQ(norms().first, 0);
  model.options().surface = {.normal_quantile = 0.9f};
  EXPECT_LT(norms().first, 0.99 * both.first) << "the longest are shortened";
}

// For a loss that is a sum over pixels, the budgeted gradient is on average the one with all rays.
TEST(RayBudget, GradientIsUnbiased) {
  const LayeredRoom r = furnished_room({}, 6);
  LayeredModel model(exact_options());
  Frame frame;
  const auto gradient = [&](uint64_t step, int budget) {
    model.options().surface.ray_budget = budget;
    frame.seed = 4;
    frame.step = step;
    model.forward(r.scene, r.view, frame);
    // The derivative of the full picture's loss: a budgeted picture knows the radiance of its chosen pixels only.
    start_gradient(frame);
    SplatScene grad = r.scene.zeros_like();
    model.backward(r.scene, frame, grad);
    return grad;
  };
  const SplatScene full = gradient(0, 0);
  const size_t pixels = frame.pixel_count();
  const int budget = static_cast<int>(pixels * 2 / 5);
  constexpr int kSteps = 400;
  struct Tally {
    LayerKind kind;
    Attribute attribute;
    std::vector<double> sum = {}, squares = {};
  };
  std::vector<Tally> tallies{{LayerKind::Reflection, Attribute::ShDc},
                             {LayerKind::Transmittance, Attribute::ShDc},
                             {LayerKind::Diffuse, Attribute::SpecularWeight},
                             {LayerKind::Diffuse, Attribute::ShDc}};
  std::vector<int> chosen(pixels), size(pixels);
  for (uint64_t step = 0; step < kSteps; ++step) {
    const SplatScene one = gradient(step, budget);
    ASSERT_EQ(frame.shaded.groups(), size_t(budget));
    ASSERT_EQ(frame.reflection.rays.size(), size_t(budget));
    for (size_t g = 0; g < frame.shaded.groups(); ++g) {
      ++chosen[frame.shaded.chosen_pixel(g)];
      for (uint32_t i = frame.shaded.begin[g]; i < frame.shaded.begin[g + 1]; ++i)
        size[frame.shaded.pixels[i]] = int(frame.shaded.weight(g));
    }
    for (Tally& t : tallies) {
      const auto v = one.layer(t.kind).values(t.attribute);
      t.sum.resize(v.size());
      t.squares.resize(v.size());
      for (size_t i = 0; i < v.size(); ++i) {
        t.sum[i] += double(v[i]);
        t.squares[i] += double(v[i]) * double(v[i]);
      }
    }
  }
  for (const Tally& t : tallies)
    for (size_t i = 0; i < t.sum.size(); ++i) {
      const double mean = t.sum[i] / kSteps;
      const double deviation = std::sqrt(std::max(0.0, t.squares[i] / kSteps - mean * mean) / kSteps);
      EXPECT_NEAR(mean, double(full.layer(t.kind).values(t.attribute)[i]), 4.5 * deviation + 1e-6)
          << name(t.kind) << " " << row(t.attribute).name << " " << i;
    }
  for (size_t p = 0; p < pixels; ++p) {
    const double probability = 1.0 / size[p];
    EXPECT_NEAR(chosen[p] / double(kSteps), probability, 5 * std::sqrt(0.25 / kSteps)) << p;
  }
}

// Losses on first hits leave their gradient with the rays; it reaches the surfels that were hit.
TEST(LayeredModel, FirstHitGradientsReachTheLayer) {
  const LayeredRoom r = furnished_room({}, 9);
  LayeredModel model(exact_options());
  Frame frame;
  model.forward(r.scene, r.view, frame);
  float farthest = 0;
  for (size_t i = 0; i < frame.transmission.rays.size(); ++i) {
    EXPECT_GE(frame.transmission.values.first_hit[i], 0);
    farthest = std::max(farthest, frame.transmission.values.first_hit[i]);
    frame.transmission.gradients.first_hit[i] = frame.transmission.weight[i];
  }
  EXPECT_GT(farthest, 0.5f);
  SplatScene grad = r.scene.zeros_like();
  model.backward(r.scene, frame, grad);
  double moved = 0;
  for (float v : grad.transmittance.values(Attribute::Mean)) moved += std::abs(double(v));
  EXPECT_GT(moved, 1e-3);
  for (float v : grad.transmittance.values(Attribute::ShDc)) EXPECT_EQ(v, 0);
}

// The gate lets less through where the reflection varies, and never changes the picture.
TEST(CompositePass, GateDampsTransmissionWhereTheReflectionVaries) {
  const LayeredRoom r = furnished_room({.f0 = 0.6, .specular = 0.6}, 10);
  const auto run = [&](float strength) {
    ImageOptions options = exact_options();
    options.composite.gate = strength;
    LayeredModel model(options);
    Frame frame;
    model.forward(r.scene, r.view, frame);
    start_gradient(frame);
    SplatScene grad = r.scene.zeros_like();
    model.backward(r.scene, frame, grad);
    return std::tuple{frame.srgb, frame.transmission.grad_radiance, frame.reflection.grad_radiance};
  };
  const auto [open_picture, open, open_r] = run(0);
  const auto [gated_picture, gated, gated_r] = run(4000);
  EXPECT_EQ(open_picture, gated_picture);
  EXPECT_EQ(open_r, gated_r);
  double sum_open = 0, sum_gated = 0;
  for (size_t i = 0; i < open.size(); ++i) {
    EXPECT_LE(length(gated[i]), length(open[i]) * 1.0001f);
    sum_open += length(open[i]);
    sum_gated += length(gated[i]);
  }
  EXPECT_LT(sum_gated, 0.9 * sum_open);
  EXPECT_GT(sum_gated, 1e-3 * sum_open);
}

}  // namespace
}  // namespace vitrine
