// What the model with three layers shows, on scenes in which everything is known.
#include "core/render/model/layered_model.h"

#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/render/model/composite_pass.h"
#include "core/render/model/surface_pass.h"
#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/tiny_rooms.h"

namespace vitrine {
namespace {

TEST(LayeredModel, WithoutItsLayersIsTheDiffuseModelToTheBit) {
  LayeredRoom r = room({}, 2);
  ImageModel plain({});
  plain.emplace<DiffusePass>();
  plain.emplace<DisplayPass>();
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
    LayeredRoom r = furnished_room({.specular = 1e-4, .transmission = 1e-4}, 2);
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
  LayeredRoom r = room({.f0 = 0.999, .specular = 0.999}, 4, 80, 60);
  r.view.intrinsics = {80, 60, 90, 91, 40.3, 29.8};
  for (size_t i = 0; i < r.scene.diffuse.size(); ++i) {  // flat, exactly in the plane
    const LayeredRoom flat = r;
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
  model.options().composite.layer_images = true;
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
  LayeredRoom r = room({.f0 = 0.04, .specular = 0.999, .transmission = 0.999}, 4, 80, 60);
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

TEST(RayBudget, SampledLobesAverageToWhatManySamplesShow) {
  const LayeredRoom r = furnished_room({.roughness = 0.5}, 6, 13, 11);
  ImageOptions options = exact_options();
  options.reflection.lobe = Lobe::Sampled;
  LayeredModel model(options);
  Frame frame;
  model.options().reflection.samples = 200;
  model.forward(r.scene, r.view, frame);
  const std::vector<Vec3f> many = frame.reflection.radiance;
  model.options().reflection.samples = 1;
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
  const LayeredRoom r = furnished_room({}, 6);
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
  LayeredRoom r = furnished_room({}, 7, 120, 90);
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
  const LayeredRoom r = furnished_room({}, 8);
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

}  // namespace
}  // namespace vitrine
