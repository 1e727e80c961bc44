// The fast path against the reference: values within the stated bound of the cut-off, gradients, and the same bytes for any
// number of threads.
#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/render/volume/kernels/density.h"
#include "core/render/volume/line_integrals.h"
#include "core/render/volume/reference/reference.h"
#include "tests/core/render/volume/gaussian_sets.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

constexpr int kWidth = 45, kHeight = 37;  // no multiples of a tile
const Vec3d kCentre{12, -7, 3};

struct Scene {
  std::vector<Gaussian3d> set = test::random_gaussians(150, kCentre, 11);
  std::vector<Gaussian3f> fast = test::floats(set);
  std::vector<VolumeRay> rays = test::cone_rays(kWidth, kHeight, kCentre, 300, 1.1);  // far away: float would lose the offsets
  RayTiles tiles{rays, kWidth, kCentre};
};

TEST(LineIntegrals, WithoutCutOffAreThoseOfTheReference) {
  const Scene s;
  std::vector<float> values(s.rays.size());
  LineIntegrals(s.tiles, s.fast, 12).forward(values);
  const std::vector<double> expected = reference_line_integrals(s.set, s.rays);
  const double largest = *std::max_element(expected.begin(), expected.end());
  ASSERT_GT(largest, 0.5);
  for (size_t i = 0; i < values.size(); ++i) ASSERT_NEAR(double(values[i]), expected[i], 3e-6 * largest) << i;
}

TEST(LineIntegrals, CutOffStaysWithinItsBound) {
  const Scene s;
  const std::vector<double> expected = reference_line_integrals(s.set, s.rays);
  const LineIntegrals all(s.tiles, s.fast, 12);
  double furthest = 0;
  for (const double cutoff : {2., 3.}) {
    std::vector<float> values(s.rays.size());
    const LineIntegrals cut(s.tiles, s.fast, cutoff);
    EXPECT_LT(cut.instances(), all.instances() * 2 / 3);
    cut.forward(values);
    for (size_t r = 0; r < values.size(); ++r) {
      double bound = 0;
      for (const Gaussian3d& g : s.set) {
        const Whitened<double> w = whitened(g);
        bound += std::exp(-0.5 * cutoff * cutoff) * w.density * kSqrtTwoPi / length(w.matrix * s.rays[r].direction);
      }
      const double error = expected[r] - double(values[r]);
      ASSERT_LE(std::abs(error), bound + 3e-6) << "ray " << r << " at " << cutoff;
      furthest = std::max(furthest, error);
    }
  }
  EXPECT_GT(furthest, 1e-4) << "nothing was cut";
}

TEST(LineIntegrals, GradientsAreThoseOfTheReference) {
  const Scene s;
  std::vector<double> weights(s.rays.size());
  for (size_t i = 0; i < weights.size(); ++i) weights[i] = double(Rng(6, i).normal());
  const std::vector<float> gradient(weights.begin(), weights.end());
  std::vector<Gaussian3Gradient> out(s.fast.size());
  LineIntegrals(s.tiles, s.fast, 12).backward(gradient, out);
  const std::vector<double> actual = test::flat(out), expected = test::flat(reference_line_integrals_vjp(s.set, s.rays, weights));
  for (size_t v = 0; v < Gaussian3d::kValues; ++v) {  // each kind of value by itself: lengths differ
    std::vector<double> a, e;
    for (size_t i = v; i < actual.size(); i += Gaussian3d::kValues) a.push_back(actual[i]), e.push_back(expected[i]);
    const GradTolerance tolerance{.relative_l2 = 3e-5, .bias = 3e-5};
    EXPECT_EQ((compare_gradients<double, double>(a, e, tolerance).problem(tolerance)), "") << "value " << v;
  }
}

TEST(LineIntegrals, SameBytesForAnyNumberOfThreads) {
  const Scene s;
  const std::vector<float> gradient(s.rays.size(), 0.5f);
  std::vector<std::vector<float>> values;
  std::vector<std::vector<Gaussian3Gradient>> gradients;
  for (const int threads : {1, 2, 5}) {
    set_thread_limit(threads);
    const LineIntegrals integrals(s.tiles, s.fast);
    integrals.forward(values.emplace_back(s.rays.size()));
    integrals.backward(gradient, gradients.emplace_back(s.fast.size()));
  }
  set_thread_limit(0);
  EXPECT_EQ(values[0], values[1]);
  EXPECT_EQ(values[0], values[2]);
  EXPECT_TRUE(gradients[0] == gradients[1] && gradients[0] == gradients[2]);
}

TEST(LineIntegrals, PixelsOfOneLineAreRaysToo) {
  const Scene s;
  const std::vector<VolumeRay> few(s.rays.begin() + 500, s.rays.begin() + 511);
  const RayTiles tiles(few, 1, kCentre);
  std::vector<float> values(few.size());
  LineIntegrals(tiles, s.fast, 12).forward(values);
  const std::vector<double> expected = reference_line_integrals(s.set, few);
  for (size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(double(values[i]), expected[i], 1e-5);
}

}  // namespace
}  // namespace vitrine
