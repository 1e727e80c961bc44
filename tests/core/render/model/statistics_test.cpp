// What the reverse says about the surfels of each layer beside their gradients.
#include <gtest/gtest.h>

#include "tests/core/render/model/showcase.h"

namespace vitrine {
namespace {

struct Pictured {
  const char* name;
  ImageOptions options;
  SplatScene scene;
  View view;
};

Pictured known_sheets() {
  const test::Showcase s;
  return {"known sheets", s.options(), s.scene, s.view};
}
Pictured through(Glass glass) {
  const LayeredRoom r = furnished_room({}, 3);
  ImageOptions options = exact_options();
  options.transmission.glass = glass;
  return {glass == Glass::Thin ? "thin glass" : "traced glass", options, r.scene, r.view};
}
// A flat mirror shows what stands behind thin glass once more.
Pictured mirror_before_glass() {
  test::Showcase s;
  const Plane plane{{0, -test::kHalf, 0}, {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {0.2, 0.2}};
  s.set->entries = {{plane, ShapeRole::Mirror, test::kSheetTolerance, -1, {}}};
  for (const double x : {-0.1, 0.1})
    for (const double z : {-0.1, 0.1}) {
      const size_t i = add_surfel(s.scene.diffuse, {{x, -test::kHalf - 0.01, z}, {0, -1, 0}, 0.1, 0.97, {0, 0, 0}}, 1);
      *s.scene.diffuse.at(Attribute::SpecularWeight, i) = logit(0.9f);
      *s.scene.diffuse.at(Attribute::Transmission, i) = logit(1e-4f);
    }
  s.dull(s.scene.transmittance, {.mean = {-1, -1.6, 0.2}, .normal = {1, 1, 0}, .size = 0.4, .opacity = 0.9});
  return {"a flat mirror", s.options(), s.scene, s.view};
}

std::vector<Pictured> pictures() { return {known_sheets(), through(Glass::Thin), through(Glass::Traced), mirror_before_glass()}; }

std::vector<SurfelStatistics> statistics(const Frame& frame) {
  return {frame.statistics, frame.reflection.statistics, frame.transmission.statistics};
}

void blame_all(Frame& frame) { frame.error_image.assign(frame.pixel_count(), 1.f); }

bool equal(const SurfelStatistics& a, const SurfelStatistics& b) { return a.weight == b.weight && a.error == b.error; }

// Whatever the last picture left, and however often the reverse runs.
TEST(Statistics, AreThoseOfOneReverse) {
  for (Pictured& p : pictures()) {
    SCOPED_TRACE(p.name);
    const LayeredModel model(p.options);
    SplatScene grad = p.scene.zeros_like();
    Frame frame;
    std::vector<std::vector<SurfelStatistics>> runs;
    model.forward(p.scene, p.view, frame);
    for (int run = 0; run < 3; ++run) {
      blame_all(frame);
      start_gradient(frame);
      if (run == 2)
        for (auto* s : {&frame.statistics, &frame.reflection.statistics, &frame.transmission.statistics})
          for (auto* values : {&s->weight, &s->error, &s->screen_gradient}) std::ranges::fill(*values, 1e6f);
      model.backward(p.scene, frame, grad);
      runs.push_back(statistics(frame));
    }
    EXPECT_GT(std::ranges::max(runs[0][2].weight), 0.1f);
    for (const auto& run : runs)
      for (size_t layer = 0; layer < 3; ++layer) EXPECT_TRUE(equal(run[layer], runs[0][layer])) << "layer " << layer;
  }
}

// No pass takes away what another has added.
TEST(Statistics, AreTheSumOverAllPasses) {
  for (Pictured& p : pictures()) {
    SCOPED_TRACE(p.name);
    const LayeredModel model(p.options);
    SplatScene grad = p.scene.zeros_like();
    Frame whole, apart;
    for (Frame* frame : {&whole, &apart}) {
      model.forward(p.scene, p.view, *frame);
      blame_all(*frame);
      start_gradient(*frame);
    }
    model.backward(p.scene, whole, grad);
    std::vector<SurfelStatistics> sums(3);
    for (size_t layer = 0; layer < 3; ++layer) sums[layer].reset(p.scene.layer(kAllLayers[layer]).size());
    size_t adding[3] = {};
    for (size_t i = model.passes().size(); i-- > 0;) {
      start_statistics(p.scene, apart);
      model.passes()[i]->backward(p.scene, apart, grad);
      const std::vector<SurfelStatistics> added = statistics(apart);
      for (size_t layer = 0; layer < 3; ++layer) {
        bool any = false;
        for (size_t k = 0; k < sums[layer].weight.size(); ++k) {
          sums[layer].weight[k] += added[layer].weight[k];
          sums[layer].error[k] += added[layer].error[k];
          any |= added[layer].weight[k] > 0;
        }
        adding[layer] += any;
      }
    }
    const std::vector<SurfelStatistics> of_whole = statistics(whole);
    for (size_t layer = 0; layer < 3; ++layer)
      for (size_t k = 0; k < sums[layer].weight.size(); ++k) {
        const SurfelStatistics& all = of_whole[layer];
        EXPECT_NEAR(all.weight[k], sums[layer].weight[k], 1e-4f * (1 + sums[layer].weight[k]));
        EXPECT_NEAR(all.error[k], sums[layer].error[k], 1e-4f * (1 + sums[layer].error[k]));
      }
    const bool mirrors = p.options.shape.set && p.options.shape.set->entries[0].role == ShapeRole::Mirror;
    if (mirrors) {
      EXPECT_GE(adding[2], 2u) << "what stands behind glass is seen straight and in the mirror";
    }
  }
}

// A layer that no pass showed has sums of zero, and says that it took no part.
TEST(Statistics, SayWhetherALayerTookPart) {
  Pictured p = through(Glass::Thin);
  const LayeredModel model(p.options);
  SplatScene grad = p.scene.zeros_like();
  Frame frame;
  const auto run = [&] {
    model.forward(p.scene, p.view, frame);
    start_gradient(frame);
    model.backward(p.scene, frame, grad);
  };
  run();
  EXPECT_TRUE(frame.reflection.took_part);
  EXPECT_TRUE(frame.transmission.took_part);
  for (const Attribute a : {Attribute::SpecularWeight, Attribute::Transmission})
    std::ranges::fill(p.scene.diffuse.values(a), logit(1e-4f));  // nothing asks for rays
  run();
  EXPECT_FALSE(frame.reflection.took_part);
  EXPECT_FALSE(frame.transmission.took_part);
  EXPECT_EQ(frame.transmission.statistics.weight, std::vector<float>(p.scene.transmittance.size(), 0.f));
  EXPECT_EQ(frame.reflection.statistics.weight, std::vector<float>(p.scene.reflection.size(), 0.f));
}

}  // namespace
}  // namespace vitrine
