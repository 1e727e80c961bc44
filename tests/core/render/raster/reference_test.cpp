// The reference renderer's backward against dual numbers and finite differences through the whole forward, on every tiny scene.
#include <gtest/gtest.h>

#include <iostream>

#include "core/foundation/math/dual.h"
#include "core/render/raster/reference/reference_pass.h"
#include "tests/support/gradcheck.h"
#include "tests/support/tiny_scenes.h"

namespace vitrine {
namespace {

using namespace reference;

constexpr size_t kStride = 3;  // every third pixel each way: the loss sees enough of them

template <class T>
PixelValues<T> upstream(uint64_t pixel, const SceneCamera<double>& view, bool distortion) {
  Rng rng(8, pixel);
  PixelValues<T> g;
  for (size_t c = 0; c < view.features; ++c) g.features[c] = T(double(rng.normal()));
  g.zdepth = T(double(rng.normal()));
  g.alpha = T(double(rng.normal()));
  g.median_z = T(double(rng.normal()));
  g.distortion = T(distortion ? 1000.0 * double(rng.normal()) : 0.0);
  return g;
}

template <class T, class Pixel>
void for_pixels(const TinyScene& scene, const std::vector<ScreenSurfel<T>>& surfels, Pixel pixel) {
  std::vector<Fragment<T>> fragments;
  const Intrinsics& k = scene.desc.intrinsics;
  for (int y = 0; y < k.height; y += kStride)
    for (int x = 0; x < k.width; x += kStride) {
      collect_fragments(surfels, T(x + 0.5), T(y + 0.5), fragments);
      pixel(fragments, static_cast<uint64_t>(y * k.width + x));
    }
}

template <class T>
T loss(const TinyScene& scene, const std::vector<SurfelValues<T>>& values) {
  const auto view = scene_camera<T>(scene.desc, scene.layer);
  const auto plain = scene_camera<double>(scene.desc, scene.layer);
  std::vector<ScreenSurfel<T>> surfels;
  for (const auto& v : values) surfels.push_back(screen_surfel(v, view));
  T sum(0);
  for_pixels(scene, surfels, [&](const auto& fragments, uint64_t pixel) {
    const PixelValues<T> out = blend_pixel(surfels, fragments, view, cast<T>(scene.desc.background));
    const PixelValues<T> g = upstream<T>(pixel, plain, scene.desc.distortion);
    for (size_t c = 0; c < view.features; ++c) sum += g.features[c] * out.features[c];
    sum += g.zdepth * out.zdepth + g.alpha * out.alpha + g.median_z * out.median_z + g.distortion * out.distortion;
  });
  return sum;
}

std::vector<SurfelValues<double>> values_of(const TinyScene& scene) {
  std::vector<SurfelValues<double>> all(scene.layer.size());
  for (size_t i = 0; i < all.size(); ++i)
    visit_values(scene.layer, all[i], [&](double& v, Attribute a, size_t c) { v = double(scene.layer.at(a, i)[c]); });
  return all;
}

std::vector<double> backward(const TinyScene& scene, const std::vector<SurfelValues<double>>& values, size_t of) {
  const auto view = scene_camera<double>(scene.desc, scene.layer);
  std::vector<ScreenSurfel<double>> surfels;
  for (const auto& v : values) surfels.push_back(screen_surfel(v, view));
  std::vector<SurfelSums<double>> sums(surfels.size());
  for_pixels(scene, surfels, [&](const auto& fragments, uint64_t pixel) {
    blend_pixel_vjp(surfels, fragments, view, cast<double>(scene.desc.background),
                    upstream<double>(pixel, view, scene.desc.distortion), 0.0, sums);
  });
  Vec2d screen;
  auto g = screen_surfel_vjp(values[of], view, surfels[of], sums[of].moments, sums[of].features, screen);
  std::vector<double> out;
  visit_values(scene.layer, g, [&](double& v, Attribute, size_t) { out.push_back(v); });
  return out;
}

TEST(ReferenceBackward, MatchesDualNumbersThroughTheWholeRenderer) {
  double worst = 0;
  size_t compared = 0;
  for (const TinyScene& scene : tiny_scenes()) {
    SCOPED_TRACE(scene.name);
    const auto values = values_of(scene);
    for (size_t of = 0; of < std::min<size_t>(values.size(), 2); ++of) {
      using D = Dual<double, 64>;
      std::vector<SurfelValues<D>> dual(values.size());
      for (size_t i = 0; i < values.size(); ++i) {
        std::vector<double> plain;
        auto copy = values[i];
        visit_values(scene.layer, copy, [&](double& v, Attribute, size_t) { plain.push_back(v); });
        size_t n = 0;
        visit_values(scene.layer, dual[i], [&](D& v, Attribute, size_t) {
          v = i == of ? D::variable(plain[n], n) : D(plain[n]);
          ++n;
        });
      }
      const D result = loss(scene, dual);
      const std::vector<double> actual = backward(scene, values, of);
      const std::vector<double> expected(result.d.begin(), result.d.begin() + static_cast<long>(actual.size()));
      const GradReport r = compare_gradients<double, double>(actual, expected, {});
      if (r.norm == 0) continue;  // culled, or hidden from the sampled pixels; backends_test covers the rest
      ++compared;
      EXPECT_EQ(r.problem({.relative_l2 = 1e-10, .bias = 1e-10}), "") << of << ": " << r.relative_l2;
      worst = std::max(worst, r.relative_l2);
    }
  }
  EXPECT_GE(compared, 20u);
  std::cout << "reference against dual numbers: worst relative L2 " << worst << " over " << compared << " surfels\n";
}

TEST(ReferenceBackward, MatchesFiniteDifferences) {
  double worst = 0;
  for (TinyScene& scene : tiny_scenes()) {
    if (scene.name != "one" && scene.name != "two_overlapping" && scene.name != "opaque_stack") continue;
    auto values = values_of(scene);
    std::vector<double> x;
    visit_values(scene.layer, values[0], [&](double& v, Attribute, size_t) { x.push_back(v); });
    const std::vector<double> expected = finite_differences(
        x,
        [&] {
          size_t n = 0;
          visit_values(scene.layer, values[0], [&](double& v, Attribute, size_t) { v = x[n++]; });
          return loss(scene, values);
        },
        1e-7);
    size_t n = 0;
    visit_values(scene.layer, values[0], [&](double& v, Attribute, size_t) { v = x[n++]; });
    worst = std::max(
        worst,
        expect_grad_close(backward(scene, values, 0), expected, {.relative_l2 = 1e-5, .bias = 1e-5}, scene.name).relative_l2);
  }
  std::cout << "reference against finite differences: worst relative L2 " << worst << "\n";
}

}  // namespace
}  // namespace vitrine
