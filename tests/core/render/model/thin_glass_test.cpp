// What stands behind thin glass: the picture of the scene without the glass, and its gradients.
#include <gtest/gtest.h>

#include "core/render/model/layered_model.h"
#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/tiny_rooms.h"

namespace vitrine {
namespace {

constexpr Attribute kShapeAndColor[] = {Attribute::Mean,    Attribute::Rotation, Attribute::LogScale,
                                        Attribute::Opacity, Attribute::ShDc,     Attribute::ShRest};

ImageOptions thin_glass() {
  ImageOptions options;
  options.diffuse.backend = Backend::Reference;
  options.surface.normal_quantile = 1;
  options.composite.gate = 0;
  options.transmission.glass = Glass::Thin;
  return options;
}

// A pane; behind it surfels of the diffuse layer and, among them, of the transmittance layer.
LayeredRoom shop_window(uint64_t seed) {
  LayeredRoom r = room({.transmission = 0.85}, seed, 13, 11);
  const size_t glass = r.scene.diffuse.size();
  const Rigid world_from_cam = inverse(r.view.cam_from_world);
  const Vec3d axis = world_from_cam.rotation * Vec3d{0, 0, 1};
  scatter(r.scene.diffuse, world_from_cam * Vec3d{0, 0, 4}, axis, 4, seed + 100);
  scatter(r.scene.transmittance, world_from_cam * Vec3d{0, 0, 4.15}, axis, 4, seed + 200);
  for (size_t i = glass; i < r.scene.diffuse.size(); ++i) *r.scene.diffuse.at(Attribute::Transmission, i) = logit(0.05f);
  return r;
}

// The scene without its glass in one layer, as a photographer who opens the window would see it.
SplatScene opened(const SplatScene& scene) {
  SplatScene out{.diffuse = SplatLayer(LayerKind::Diffuse, 1, 0)};
  const auto take = [&](const SplatLayer& from, size_t i) {
    const size_t k = out.diffuse.size();
    out.diffuse.resize(k + 1);
    for (Attribute a : kShapeAndColor) std::copy_n(from.at(a, i), from.width(a), out.diffuse.at(a, k));
  };
  for (size_t i = 0; i < scene.diffuse.size(); ++i)
    if (*scene.diffuse.at(Attribute::Transmission, i) < 0) take(scene.diffuse, i);
  for (size_t i = 0; i < scene.transmittance.size(); ++i) take(scene.transmittance, i);
  return out;
}

TEST(ThinGlass, ShowsTheSceneWithoutTheGlass) {
  const LayeredRoom r = shop_window(3);
  ImageOptions options = thin_glass();
  options.composite.layer_images = true;
  LayeredModel model(options), plain(options);
  Frame frame, without;
  model.forward(r.scene, r.view, frame);
  plain.forward(opened(r.scene), r.view, without);
  ASSERT_EQ(frame.shaded.groups(), frame.pixel_count());
  EXPECT_EQ(frame.layers.transmitted, without.linear);
  // Blended as any transmitted light is.
  const auto tau = frame.diffuse.plane(Aov::Transmission);
  for (size_t i = 0; i < frame.pixel_count(); ++i) EXPECT_NEAR(frame.layers.transmission[i], tau[i] * without.linear[i], 1e-6);
}

// Pixels that do not ask for what stands behind them do not get it; those that do, by their mask here, see it as before.
TEST(ThinGlass, IsLookedThroughOnlyWhereAPixelAsks) {
  LayeredRoom r = shop_window(3);
  for (float& tau : r.scene.diffuse.values(Attribute::Transmission)) tau = logit(1e-4f);
  LayeredModel model(thin_glass()), plain(thin_glass());
  Frame frame, without;
  plain.forward(opened(r.scene), r.view, without);
  const auto width = static_cast<size_t>(r.view.intrinsics.width), pixels = without.linear.size() / 3;
  std::vector<float> mask(pixels, 0.f);
  for (size_t i = 0; i < pixels; ++i) mask[i] = i % width < width / 2 ? 1.f : 0.f;
  frame.transparent_mask = mask;
  model.forward(r.scene, r.view, frame);
  ASSERT_EQ(frame.behind.radiance.size(), 3 * pixels);
  for (size_t i = 0; i < 3 * pixels; ++i) EXPECT_NEAR(frame.behind.radiance[i], mask[i % pixels] * without.linear[i], 1e-6) << i;
  for (size_t i = 0; i < pixels; ++i)
    if (mask[i] == 0) {
      EXPECT_EQ(frame.behind.inner_transmittance[i], 1.f);
    }
  frame.transparent_mask = std::span<const float>{};
  model.forward(r.scene, r.view, frame);
  EXPECT_TRUE(frame.behind.radiance.empty());
}

TEST(ThinGlass, EveryPixelHasItsOwnViewWhateverTheRayBudget) {
  const LayeredRoom r = shop_window(3);
  ImageOptions options = thin_glass();
  LayeredModel all(options);
  options.surface.ray_budget = 9;
  LayeredModel few(options);
  Frame of_all, of_few;
  all.forward(r.scene, r.view, of_all);
  few.forward(r.scene, r.view, of_few);
  ASSERT_EQ(of_few.shaded.groups(), 9u);
  EXPECT_EQ(of_few.linear, of_all.linear);
}

TEST(ThinGlass, GradientsMatchFiniteDifferences) {
  LayeredRoom r = shop_window(5);
  LayeredModel model(thin_glass());
  Frame frame;
  const auto loss = [&] {
    model.forward(r.scene, r.view, frame);
    return loss_of(frame);
  };
  loss();
  start_gradient(frame);
  frame.error_image.assign(frame.pixel_count(), 1.f);
  SplatScene grad = r.scene.zeros_like();
  model.backward(r.scene, frame, grad);
  // Whoever is seen through the glass is to blame for what is wrong there, in both layers.
  ASSERT_EQ(frame.statistics.error.size(), r.scene.diffuse.size());
  ASSERT_EQ(frame.transmission.statistics.error.size(), r.scene.transmittance.size());
  for (size_t i = 4; i < r.scene.diffuse.size(); ++i) EXPECT_GT(frame.statistics.error[i], 0.5f);
  for (float error : frame.transmission.statistics.error) EXPECT_GT(error, 0.5f);
  for (LayerKind kind : {LayerKind::Diffuse, LayerKind::Transmittance})
    for (Attribute a : kShapeAndColor) expect_differences(r.scene, grad, kind, a, loss);
}

TEST(ThinGlass, BytesDoNotDependOnThreads) {
  const LayeredRoom r = shop_window(7);
  ImageOptions options = thin_glass();
  options.diffuse.backend = Backend::Cpu;
  expect_same_for_threads(options, r.scene, r.view);
}

}  // namespace
}  // namespace vitrine
