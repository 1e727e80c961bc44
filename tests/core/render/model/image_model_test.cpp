#include "core/render/model/layered_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/foundation/base/error.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/color.h"
#include "core/render/model/composite_pass.h"
#include "core/render/model/shape_pass.h"
#include "core/render/model/sheet_pass.h"
#include "core/render/model/silhouette_pass.h"
#include "core/render/model/surface_pass.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {
namespace {

View small_view() {
  View view;
  view.intrinsics = {24, 18, 22, 22, 12, 9};
  view.cam_from_world.translation = {0, 0, 3};
  view.gain = {0.9, 1.1, 1.3};
  return view;
}

SplatScene small_scene(int surfels) {
  SplatScene scene{SplatLayer(LayerKind::Diffuse, 1, static_cast<size_t>(surfels))};
  Rng rng(11);
  for (size_t i = 0; i < scene.diffuse.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) scene.diffuse.at(Attribute::Mean, i)[c] = rng.normal() * 0.6f;
    for (size_t c = 0; c < 4; ++c) scene.diffuse.at(Attribute::Rotation, i)[c] = rng.normal();
    for (size_t c = 0; c < 2; ++c) scene.diffuse.at(Attribute::LogScale, i)[c] = std::log(0.4f);
    for (size_t c = 0; c < 3; ++c) scene.diffuse.at(Attribute::ShDc, i)[c] = rng.uniform() - 1.f;
    *scene.diffuse.at(Attribute::Opacity, i) = rng.normal();
  }
  return scene;
}

Frame frame_with_linear(const View& view, float low, float high) {
  Frame frame;
  frame.view = &view;
  frame.linear.resize(3 * frame.pixel_count());
  for (size_t i = 0; i < frame.linear.size(); ++i) frame.linear[i] = low + (high - low) * float(i) / float(frame.linear.size());
  return frame;
}

TEST(DisplayPass, IsTheSrgbTransferOfTheGainedRadiance) {
  const View view = small_view();
  Frame frame = frame_with_linear(view, -0.1f, 1.3f);
  const SplatScene none;
  DisplayPass().forward(none, frame);
  const size_t pixels = frame.pixel_count();
  for (size_t i = 0; i < frame.linear.size(); ++i) {
    const double l = std::clamp(view.gain[i / pixels] * double(frame.linear[i]), 0.0, 1.0);
    EXPECT_NEAR(frame.srgb[i], srgb_from_linear(l), 1e-6) << l;
  }
}

TEST(DisplayPass, ReverseMatchesTheExactSlope) {
  const View view = small_view();
  Frame frame = frame_with_linear(view, 0.0002f, 0.76f);  // gain * l stays below one
  SplatScene none;
  DisplayPass pass;
  pass.forward(none, frame);
  for (size_t i = 0; i < frame.grad_srgb.size(); ++i) frame.grad_srgb[i] = i % 2 ? 1.f : -2.f;
  pass.backward(none, frame, none);
  const size_t pixels = frame.pixel_count();
  for (size_t i = 0; i < frame.linear.size(); ++i) {
    const double gain = view.gain[i / pixels], l = gain * double(frame.linear[i]);
    const double exact = gain * srgb_from_linear_slope(l) * frame.grad_srgb[i];
    EXPECT_NEAR(frame.grad_linear[i], exact, 2e-5 * std::abs(exact)) << l;
  }
}

TEST(DisplayPass, ClippedPixelsOnlyComeBackIntoRange) {
  const View view = small_view();
  Frame frame = frame_with_linear(view, 1.2f, 1.2f);
  SplatScene none;
  DisplayPass pass;
  pass.forward(none, frame);
  for (size_t i = 0; i < frame.grad_srgb.size(); ++i) frame.grad_srgb[i] = i % 2 ? 1.f : -1.f;
  pass.backward(none, frame, none);
  for (size_t i = 0; i < frame.linear.size(); ++i) EXPECT_EQ(frame.grad_linear[i] > 0, i % 2 == 1);
}

std::string refusal(const std::function<void(ImageModel&)>& add) {
  ImageModel model({});
  try {
    add(model);
  } catch (const Error& e) {
    return e.message();
  }
  return "none";
}

TEST(ImageModel, RefusesPassesInAWrongOrder) {
  EXPECT_EQ(refusal([](ImageModel& m) { m.emplace<DisplayPass>(); }),
            "pass 'display' reads 'linear radiance', which no pass before it writes");
  EXPECT_EQ(refusal([](ImageModel& m) {
              m.emplace<DiffusePass>();
              m.emplace<SheetPass>();
              m.emplace<SurfacePass>();
            }),
            "pass 'surface' reads 'coats', which no pass before it writes");
  EXPECT_EQ(refusal([](ImageModel& m) {
              m.emplace<DiffusePass>();
              m.emplace<SheetPass>();
              m.emplace<ShapePass>();
              m.emplace<SurfacePass>();
              m.emplace<SilhouettePass>(Backend::Reference);
            }),
            "pass 'silhouette' adds to 'coats', which pass 'surface' before it has read");
  EXPECT_EQ(refusal([](ImageModel& m) {
              m.emplace<DiffusePass>();
              m.emplace<DiffusePass>();
            }),
            "pass 'diffuse' writes 'diffuse channels' as pass 'diffuse' does");
  EXPECT_EQ(refusal([](ImageModel& m) { m.emplace<ShapePass>(); }),
            "pass 'shape' adds to 'diffuse channels', which no pass before it writes");
}

// The whole list, through the rasteriser: colours and opacities against central differences of a quadratic loss.
TEST(ImageModel, GradientRunsThroughThePassesInReverse) {
  const View view = small_view();
  SplatScene scene = small_scene(12);
  ImageModel model({.diffuse = {.backend = Backend::Reference, .sh_degree = 1}});
  model.emplace<DiffusePass>(Backend::Reference);
  model.emplace<DisplayPass>();
  Frame frame;
  const auto loss = [&] {
    model.forward(scene, view, frame);
    double sum = 0;
    for (size_t i = 0; i < frame.srgb.size(); ++i) sum += 0.5 * std::pow(frame.srgb[i] - 0.3, 2);
    return sum;
  };
  loss();
  for (size_t i = 0; i < frame.srgb.size(); ++i) frame.grad_srgb[i] = frame.srgb[i] - 0.3f;
  SplatScene grad{scene.diffuse.zeros_like()};
  model.backward(scene, frame, grad);
  double worst = 0, norm = 0;
  for (Attribute a : {Attribute::ShDc, Attribute::ShRest, Attribute::Opacity})
    for (size_t i = 0; i < scene.diffuse.values(a).size(); ++i) {
      float& x = scene.diffuse.values(a)[i];
      const float kept = x, h = 4e-3f;
      x = kept + h;
      const double up = loss();
      x = kept - h;
      const double down = loss();
      x = kept;
      const double exact = grad.diffuse.values(a)[i], difference = (up - down) / (2 * double(h));
      worst = std::max(worst, std::abs(exact - difference));
      norm = std::max(norm, std::abs(exact));
    }
  EXPECT_GT(norm, 1e-3);
  EXPECT_LT(worst, 2e-2 * norm);
}

}  // namespace
}  // namespace vitrine
