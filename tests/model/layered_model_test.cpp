// What the model with three layers promises, on scenes in which everything is known.
#include "core/model/layered_model.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/base/parallel.h"
#include "core/model/display_pass.h"
#include "tests/model/tiny_rooms.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

// In double and without what is meant to alter gradients: a model that finite differences can be held against.
ImageOptions exact_options() {
  ImageOptions o;
  o.diffuse.backend = Backend::Reference;
  o.surface.normal_quantile = 1;
  o.composite.gate = 0;
  o.reflection.max_footprint = 1;
  return o;
}

const Attribute kAll[] = {Attribute::Mean,           Attribute::Rotation,    Attribute::LogScale, Attribute::Opacity,
                          Attribute::ShDc,           Attribute::ShRest,      Attribute::F0,       Attribute::Roughness,
                          Attribute::SpecularWeight, Attribute::Transmission};

void start_gradient(Frame& frame) {
  for (size_t i = 0; i < frame.srgb.size(); ++i) frame.grad_srgb[i] = frame.srgb[i] - 0.3f;
}

TEST(LayeredModel, WithoutItsLayersIsTheDiffuseModelToTheBit) {
  TinyRoom r = room({}, 2);
  ImageModel plain;
  plain.add(std::make_unique<DiffusePass>(DiffuseOptions{}));
  plain.add(std::make_unique<DisplayPass>());
  LayeredModel layered(ImageOptions{});
  Frame a, b;
  SplatScene grad_a = r.scene.zeros_like(), grad_b = grad_a;
  plain.forward(r.scene, r.view, a);
  layered.forward(r.scene, r.view, b);
  EXPECT_EQ(a.srgb, b.srgb);
  EXPECT_TRUE(b.diffuse.plane(Aov::F0).empty()) << "materials are blended for nobody";
  EXPECT_EQ(b.shaded.groups(), 0u);
  for (Frame* f : {&a, &b}) start_gradient(*f);
  plain.backward(r.scene, a, grad_a);
  layered.backward(r.scene, b, grad_b);
  EXPECT_EQ(grad_a.diffuse, grad_b.diffuse);
}

TEST(LayeredModel, OpaqueSurfacesWithoutSpecularWeightKeepTheirColour) {
  for (LayerBlend blend : {LayerBlend::RtrGs, LayerBlend::Layered}) {
    TinyRoom r = furnished_room({.specular = 1e-4, .transmission = 1e-4}, 2);
    ImageOptions options = exact_options();
    options.composite.blend = blend;
    LayeredModel model(options);
    Frame frame;
    model.forward(r.scene, r.view, frame);
    const auto color = frame.diffuse.plane(Aov::Color);
    EXPECT_EQ(std::vector<float>(color.begin(), color.end()), frame.linear);
    EXPECT_EQ(frame.shaded.groups(), 0u);
    // A mask makes the same pixels send rays.
    const std::vector<float> mask(frame.pixel_count(), 1.f);
    frame.specular_mask = mask;
    model.forward(r.scene, r.view, frame);
    EXPECT_EQ(frame.shaded.groups(), frame.pixel_count());
    EXPECT_FALSE(frame.reflection.rays.empty());
    EXPECT_TRUE(frame.transmission.rays.empty());
    frame.transparent_mask = mask;
    model.forward(r.scene, r.view, frame);
    EXPECT_EQ(frame.transmission.rays.size(), frame.pixel_count());
  }
}

// One bright surfel before a mirror: the picture of it stands where its mirror image projects.
TEST(LayeredModel, MirrorShowsAThingWhereGeometrySaysSo) {
  TinyRoom r = room({.f0 = 0.999, .specular = 0.999}, 4, 80, 60);
  r.view.intrinsics = {80, 60, 90, 91, 40.3, 29.8};
  for (size_t i = 0; i < r.scene.diffuse.size(); ++i) {  // flat, exactly in the plane
    const TinyRoom flat = r;
    SplatLayer one(LayerKind::Diffuse, 1, 0);
    add_surfel(one, {.mean = r.point, .normal = r.normal, .size = 3}, 1);
    for (Attribute a : {Attribute::Mean, Attribute::Rotation}) std::copy_n(one.at(a, 0), one.width(a), r.scene.diffuse.at(a, i));
  }
  const Vec3d behind = inverse(r.view.cam_from_world) * Vec3d{0.35, -0.2, 4};  // where it seems to be
  const Vec3d thing = mirrored(r, behind);
  EXPECT_GT(dot(thing - r.point, r.normal), 0.5) << "the thing stands before the mirror";
  add_surfel(r.scene.reflection,
             {.mean = thing, .normal = normalized(r.point - thing), .size = 0.1, .opacity = 0.95, .rgb = {1, 1, 1}}, 1);
  LayeredModel model(exact_options());
  model.composite->options().layer_images = true;
  Frame frame;
  model.forward(r.scene, r.view, frame);
  double sum = 0, x = 0, y = 0;
  for (size_t i = 0; i < frame.pixel_count(); ++i) {
    const double v = double(frame.layers.reflection[i]);
    sum += v;
    x += v * (double(i % 80) + 0.5);
    y += v * (double(i / 80) + 0.5);
  }
  const Vec3d seen = r.view.cam_from_world * behind;
  EXPECT_GT(sum, 5);
  EXPECT_NEAR(x / sum, 90 * seen.x / seen.z + 40.3, 0.1);
  EXPECT_NEAR(y / sum, 91 * seen.y / seen.z + 29.8, 0.1);
}

// The same behind a pane: straight on, dimmed by what the pane reflects; nothing in front of the pane is seen through it.
TEST(LayeredModel, GlassShowsAThingBehindItStraightOn) {
  TinyRoom r = room({.f0 = 0.04, .specular = 0.999, .transmission = 0.999}, 4, 80, 60);
  r.view.intrinsics = {80, 60, 90, 91, 40.3, 29.8};
  const Rigid world_from_cam = inverse(r.view.cam_from_world);
  const auto lamp = [&](const Vec3d& in_camera) {
    const Vec3d at = world_from_cam * in_camera;
    add_surfel(r.scene.transmittance,
               {.mean = at, .normal = at - r.view.centre_in_world(), .size = 0.1, .opacity = 0.95, .rgb = {1, 1, 1}}, 1);
  };
  lamp({0.35, -0.2, 4});
  lamp({-0.1, 0.05, 0.8});
  ImageOptions options = exact_options();
  options.composite.blend = LayerBlend::RtrGs;
  options.composite.layer_images = true;
  options.transmission.sh_degree = 0;
  LayeredModel model(options);
  Frame frame;
  model.forward(r.scene, r.view, frame);
  double sum = 0, x = 0, y = 0, peak = 0;
  for (size_t i = 0; i < frame.pixel_count(); ++i) {
    const double v = double(frame.layers.transmission[i]);
    sum += v;
    peak = std::max(peak, v);
    x += v * (double(i % 80) + 0.5);
    y += v * (double(i / 80) + 0.5);
  }
  EXPECT_NEAR(x / sum, 90 * 0.35 / 4 + 40.3, 0.1);
  EXPECT_NEAR(y / sum, 91 * -0.2 / 4 + 29.8, 0.1);
  // No reflection layer: nothing is taken from the transmitted light. Transmission and specular weight of the sheet are about
  // .998.
  EXPECT_NEAR(peak, 0.95, 0.03);
}

class WholeChain : public testing::TestWithParam<std::tuple<LayerBlend, Lobe>> {};

// Pixel loss -> display -> composite -> rays -> all three layers, against central differences. Every group of parameters on its
// own, so that a large one does not hide a small one.
TEST_P(WholeChain, MatchesFiniteDifferences) {
  ImageOptions options = exact_options();
  std::tie(options.composite.blend, options.reflection.lobe) = GetParam();
  TinyRoom r = furnished_room({}, 5, 13, 11);
  LayeredModel model(options);
  Frame frame;
  const auto loss = [&] {
    model.forward(r.scene, r.view, frame);
    double sum = 0;
    for (float v : frame.srgb) sum += 0.5 * std::pow(double(v) - 0.3, 2);
    return sum;
  };
  loss();
  ASSERT_EQ(frame.shaded.groups(), frame.pixel_count());
  start_gradient(frame);
  SplatScene grad = r.scene.zeros_like();
  model.backward(r.scene, frame, grad);
  for (LayerKind kind : kAllLayers)
    for (Attribute a : kAll) {
      auto values = r.scene.layer(kind).values(a);
      if (values.empty() || (a == Attribute::Roughness && options.reflection.lobe == Lobe::Mirror)) continue;
      std::vector<double> differences;
      std::vector<float> actual;
      for (size_t i = 0; i < values.size(); ++i) {
        const float kept = values[i], h = 2e-3f;
        const auto slope = [&](float step) {
          values[i] = kept + step;
          const double up = loss();
          values[i] = kept - step;
          const double down = loss();
          values[i] = kept;
          return (up - down) / (2 * double(step));
        };
        differences.push_back((4 * slope(h) - slope(2 * h)) / 3);
        actual.push_back(grad.layer(kind).values(a)[i]);
      }
      // Worst seen: 6e-3 (scales of the sheets).
      expect_grad_close(actual, differences, {.relative_l2 = 2e-2, .bias = 2e-2, .row_floor = 0.05},
                        std::string(name(kind)) + " " + std::string(row(a).name));
    }
}

INSTANTIATE_TEST_SUITE_P(All, WholeChain,
                         testing::Values(std::tuple{LayerBlend::RtrGs, Lobe::Mirror},
                                         std::tuple{LayerBlend::Layered, Lobe::Mirror},
                                         std::tuple{LayerBlend::Layered, Lobe::Cone}));

TEST(LayeredModel, DepthAndNormalGradientsCanBeCut) {
  const TinyRoom r = furnished_room({}, 5);
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
  model.surface->options().depth_gradient = false;
  EXPECT_EQ(norms().second, 0);
  EXPECT_EQ(norms().first, both.first);
  model.surface->options().normal_gradient = false;
  EXPECT_EQ(norms().first, 0);
  model.surface->options() = {.normal_quantile = 0.9f};
  EXPECT_LT(norms().first, 0.99 * both.first) << "the longest are shortened";
}

// For a loss that is a sum over pixels, the budgeted gradient is on average the one with all rays.
TEST(RayBudget, GradientIsUnbiased) {
  const TinyRoom r = furnished_room({}, 6);
  LayeredModel model(exact_options());
  Frame frame;
  const auto gradient = [&](uint64_t step, int budget) {
    model.surface->options().ray_budget = budget;
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

TEST(RayBudget, SampledLobesAverageToWhatManySamplesShow) {
  const TinyRoom r = furnished_room({.roughness = 0.5}, 6, 13, 11);
  ImageOptions options = exact_options();
  options.reflection.lobe = Lobe::Sampled;
  LayeredModel model(options);
  Frame frame;
  model.reflection->options().samples = 200;
  model.forward(r.scene, r.view, frame);
  const std::vector<Vec3f> many = frame.reflection.radiance;
  model.reflection->options().samples = 1;
  std::vector<Vec3f> mean(many.size());
  constexpr int kSteps = 200;
  for (int step = 0; step < kSteps; ++step) {
    frame.step = static_cast<uint64_t>(step);
    model.forward(r.scene, r.view, frame);
    for (size_t i = 0; i < mean.size(); ++i) mean[i] += (1.f / kSteps) * frame.reflection.radiance[i];
  }
  for (size_t i = 0; i < mean.size(); ++i)
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(mean[i][c], many[i][c], 5e-3);
}

TEST(LayeredModel, APictureWithoutGradientsIsTheSameAndKeepsNoHits) {
  const TinyRoom r = furnished_room({}, 6);
  ImageOptions options = exact_options();
  options.reflection.lobe = Lobe::Sampled;
  options.reflection.samples = 9;
  LayeredModel model(options);
  Frame full, lean;
  lean.differentiable = false;
  model.forward(r.scene, r.view, full);
  model.forward(r.scene, r.view, lean);
  for (size_t i = 0; i < full.linear.size(); ++i) EXPECT_NEAR(full.linear[i], lean.linear[i], 1e-6);
  EXPECT_GT(full.reflection.hits.size(), 0u);
  EXPECT_EQ(lean.reflection.hits.size() + lean.transmission.hits.size(), 0u);
  EXPECT_LE(lean.reflection.rays.size(), lean.pixel_count());
}

TEST(LayeredModel, BytesDoNotDependOnThreads) {
  TinyRoom r = furnished_room({}, 7, 120, 90);
  r.view.intrinsics.fx = r.view.intrinsics.fy = 200;
  ImageOptions options;
  options.surface.ray_budget = 3000;
  options.reflection.lobe = Lobe::Sampled;
  const auto run = [&](int threads) {
    set_thread_limit(threads);
    LayeredModel model(options);
    Frame frame;
    frame.seed = 3;
    frame.step = 17;
    const std::vector<float> blame(static_cast<size_t>(120 * 90), 0.5f);
    frame.error_image = blame;
    model.forward(r.scene, r.view, frame);
    start_gradient(frame);
    SplatScene grad = r.scene.zeros_like();
    model.backward(r.scene, frame, grad);
    EXPECT_GT(frame.reflection.statistics.error[0], 0);
    return std::tuple{frame.srgb, grad.diffuse, grad.reflection, grad.transmittance, frame.reflection.statistics.error};
  };
  const auto one = run(1);
  EXPECT_TRUE(one == run(2));
  EXPECT_TRUE(one == run(5));
  set_thread_limit(0);
}

TEST(CompositePass, LayerImagesAddUpToThePicture) {
  const TinyRoom r = furnished_room({}, 8);
  ImageOptions options = exact_options();
  options.composite.layer_images = true;
  LayeredModel model(options);
  Frame frame;
  model.forward(r.scene, r.view, frame);
  const LayerImages& l = frame.layers;
  float through = 1;
  for (size_t i = 0; i < frame.linear.size(); ++i)
    EXPECT_NEAR(l.diffuse[i] + l.reflection[i] + l.transmission[i], frame.linear[i], 1e-6);
  for (float v : l.inner_transmittance) through = std::min(through, v);
  EXPECT_LT(through, 0.9f);
  EXPECT_GT(*std::max_element(l.fresnel.begin(), l.fresnel.end()), 0.3f);
}

// Losses on first hits leave their gradient with the rays; it reaches the surfels that were hit.
TEST(LayeredModel, FirstHitGradientsReachTheLayer) {
  const TinyRoom r = furnished_room({}, 9);
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
  const TinyRoom r = furnished_room({.f0 = 0.6, .specular = 0.6}, 10);
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
