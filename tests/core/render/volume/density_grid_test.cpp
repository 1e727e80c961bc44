// Densities on a grid against the kernel at each cell, their reverse, and that a projected grid is the line integral.
#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/render/volume/density_grid.h"
#include "core/render/volume/kernels/density.h"
#include "core/render/volume/line_integrals.h"
#include "tests/core/render/volume/gaussian_sets.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

VoxelGrid<float> small_grid() { return {.origin = {-1, -0.8, -0.9}, .cell = 0.1, .size = {19, 17, 15}, .values = {}}; }

TEST(DensityGrid, IsTheSumOfTheGaussiansAtEachCell) {
  const std::vector<Gaussian3d> set = test::random_gaussians(60, {}, 21);  // some lie outside in part
  VoxelGrid<float> grid = small_grid();
  sample_density(test::floats(set), grid);
  double largest = 0;
  grid.each_in_order([&](int x, int y, int z) {
    double expected = 0, cut = 0;
    for (const Gaussian3d& g : set) {
      const Whitened<double> w = whitened(g);
      const double value = density_at(w, g.mean, grid.centre(x, y, z));
      (value < w.density * std::exp(-0.5 * kVolumeCutoff * kVolumeCutoff) ? cut : expected) += value;
    }
    EXPECT_NEAR(double(grid.at(x, y, z)), expected, 1e-5 * expected + 1e-6) << x << " " << y << " " << z << ", cut " << cut;
    largest = std::max(largest, expected);
  });
  EXPECT_GT(largest, 1);
}

TEST(DensityGrid, GradientsAreThoseOfTheKernel) {
  const std::vector<Gaussian3d> set = test::random_gaussians(25, {}, 22);
  VoxelGrid<float> gradient = small_grid();
  for (size_t i = 0; i < gradient.count(); ++i) gradient.values.push_back(Rng(3, i).normal());
  std::vector<Gaussian3Gradient> out(set.size());
  sample_density_vjp(test::floats(set), gradient, out);
  std::vector<Gaussian3d> expected;
  for (const Gaussian3d& g : set) {
    const Whitened<double> w = whitened(g);
    WhitenedGradient<double> sums;
    gradient.each_in_order([&](int x, int y, int z) {
      const Vec3d p = gradient.centre(x, y, z);
      if (squared_length(w.matrix * (p - g.mean)) <= kVolumeCutoff * kVolumeCutoff)
        density_at_vjp(w, g.mean, p, double(gradient.at(x, y, z)), sums);
    });
    expected.push_back(whitened_vjp(g, w, sums));
  }
  const GradTolerance tolerance{.relative_l2 = 1e-5, .bias = 1e-5, .row_width = Gaussian3d::kValues};
  EXPECT_EQ((compare_gradients<double, double>(test::flat(out), test::flat(expected), tolerance).problem(tolerance)), "");
}

TEST(DensityGrid, SumsAlongAnAxisAreLineIntegrals) {
  const std::vector<Gaussian3f> set = test::floats(test::random_gaussians(40, {}, 23));
  VoxelGrid<float> grid{.origin = {-2.5, -2.5, -2.5}, .cell = 0.05, .size = {100, 100, 100}, .values = {}};
  sample_density(set, grid);
  std::vector<VolumeRay> rays;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) rays.push_back({grid.centre(x, y, 0), {0, 0, 1}});
  const RayTiles tiles(rays, 100, {});
  std::vector<float> values(rays.size());
  LineIntegrals(tiles, set).forward(values);
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      double sum = 0;
      for (int z = 0; z < 100; ++z) sum += grid.cell * double(grid.at(x, y, z));
      ASSERT_NEAR(double(values[size_t(y * 100 + x)]), sum, 0.01) << x << " " << y;
    }
}

TEST(DensityGrid, SameBytesForAnyNumberOfThreads) {
  const std::vector<Gaussian3f> set = test::floats(test::random_gaussians(200, {}, 24));
  std::vector<std::vector<float>> values;
  std::vector<std::vector<Gaussian3Gradient>> gradients;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    VoxelGrid<float> grid = small_grid();
    sample_density(set, grid);
    sample_density_vjp(set, grid, gradients.emplace_back(set.size()));
    values.push_back(grid.values);
  }
  set_thread_limit(0);
  EXPECT_EQ(values[0], values[1]);
  EXPECT_TRUE(gradients[0] == gradients[1]);
}

}  // namespace
}  // namespace vitrine
