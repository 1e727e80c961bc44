// Prints PSNR of 25, 50, 75 projections, without noise and with that of 10 000 photons: backprojection, SIRT, the fit; 64^3
// voxels of the head phantom, 96 x 96 pixels.
#include <gtest/gtest.h>

#include "stages/tomography/voxel_fit.h"
#include "tests/stages/tomography/filtered_backprojection.h"
#include "tests/stages/tomography/phantoms.h"
#include "tests/stages/tomography/sirt.h"

namespace vitrine {
namespace {

TEST(Table, FitAgainstBackprojectionAndSirt) {
  for (const int views : {25, 50, 75})
    for (const double photons : {0., 1e4}) {
      const ScanGeometry g = test::cone_scan(views, 96);
      const std::vector<ImageF> projections = test::counted(test::scanned(g, test::head()), photons);
      VoxelGrid<float> fitted{.origin = {-1, -1, -1}, .cell = 2. / 64, .size = {64, 64, 64}, .values = {}};
      VoxelGrid<float> backprojected = fitted, sirt = fitted;
      const VoxelGrid<float> truth = test::truth(test::head(), fitted);
      test::filtered_backprojection(g, projections, backprojected);
      fit_voxels(g, projections, fitted, {});
      test::sirt(g, projections, VoxelFitDesc{}.rounds, sirt);
      const double ours = test::psnr(fitted, truth), other = test::psnr(backprojected, truth), rounds = test::psnr(sirt, truth);
      fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.1f} |\n", views, photons, other, rounds, ours);
      EXPECT_GT(ours, other + 3);
      EXPECT_GT(ours, rounds + 1);
    }
}

}  // namespace
}  // namespace vitrine
