// Volumes of phantoms with known density: projections of the geometry, filtered backprojection, the fit against it and SIRT, the
// surface and the NRRD file.
#include <cstring>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/render/volume/density_grid.h"
#include "stages/tomography/filtered_backprojection.h"
#include "stages/tomography/tomography.h"
#include "stages/tomography/volume_fit.h"
#include "tests/stages/tomography/phantoms.h"
#include "tests/stages/tomography/sirt.h"

namespace vitrine {
namespace {

VoxelGrid<float> unit_grid(int side) {
  return {.origin = {-1, -1, -1}, .cell = 2. / side, .size = {side, side, side}, .values = {}};
}
const test::Phantom& ball() {
  static const test::Phantom phantom{{{.6, .6, .6}, {0.1, -0.15, 0.05}, 0, 2}};
  return phantom;
}

TEST(ScanGeometry, RaysPassThePointsThatTheyShow) {
  for (ScanGeometry g : {test::cone_scan(4, 40), test::parallel_scan(4, 40)}) {
    g.detector_offset = {0.13, -0.07};
    for (const double angle : {0., 0.4, 2.5}) {
      const std::vector<VolumeRay> rays = scan_rays(g, angle);
      for (const int pixel : {0, 39, 815, 1599}) {
        const Vec3d point = rays[size_t(pixel)].origin + 5.5 * rays[size_t(pixel)].direction;
        const DetectorPoint seen = detector_point(g, angle, point);
        EXPECT_NEAR(seen.x, pixel % 40 + 0.5, 1e-9);
        EXPECT_NEAR(seen.y, pixel / 40 + 0.5, 1e-9);
      }
    }
  }
}

TEST(ScanGeometry, TheSeenCylinderTouchesTheBorderOfTheProjections) {
  const ScanGeometry g = test::cone_scan(1, 40);
  const SeenCylinder seen = seen_cylinder(g);
  double across = 0, up = 0;
  for (int i = 0; i < 3600; ++i) {
    const double a = i * std::numbers::pi / 1800;
    const DetectorPoint d = detector_point(g, 0, {seen.radius * std::cos(a), seen.radius * std::sin(a), seen.half_height});
    across = std::max(across, std::abs(d.x - 20)), up = std::max(up, std::abs(d.y - 20));
  }
  EXPECT_NEAR(across, 20, 1e-3);
  EXPECT_NEAR(up, 20, 1e-3);
}

// Exact but for sampling: the plane of the source's circle, and the integrals along lines parallel to the axis (Feldkamp, Davis
// and Kress 1984). Elsewhere cone beams leave errors that no sampling removes.
TEST(FilteredBackprojection, GivesTheDensityOfABall) {
  constexpr double kRadius = 0.6, kDensity = 2, kSampling = 0.04;  // of 90 views, 40 pixels, 24 cells
  for (const ScanGeometry& g : {test::cone_scan(90, 40), test::parallel_scan(90, 40)}) {
    VoxelGrid<float> volume = unit_grid(24);
    filtered_backprojection(g, test::scanned(g, ball()), volume);
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 24; ++x) {
        double column = 0;
        for (int z = 0; z < 24; ++z) column += volume.cell * double(volume.at(x, y, z));
        const Vec3d d = volume.centre(x, y, 12) - ball()[0].centre;
        const double across = std::hypot(d.x, d.y), middle = double(volume.at(x, y, 12));
        if (across < kRadius - 0.15) {
          EXPECT_NEAR(column, 2 * kDensity * std::sqrt(kRadius * kRadius - across * across), kSampling * 2 * kDensity * kRadius);
          EXPECT_NEAR(middle, kDensity, kSampling * kDensity) << x << " " << y;
        } else if (across > kRadius + 0.15 && std::hypot(volume.centre(x, y, 0).x, volume.centre(x, y, 0).y) < 0.95) {
          EXPECT_NEAR(column, 0, kSampling * 2 * kDensity * kRadius);
          EXPECT_NEAR(middle, 0, kSampling * kDensity) << x << " " << y;
        }
      }
  }
}

TEST(FilteredBackprojection, AnglesStandForTheWayToTheirNeighbours) {
  ScanGeometry g = test::parallel_scan(4, 8);
  for (const double w : angle_weights(g)) EXPECT_NEAR(w, std::numbers::pi / 4, 1e-12);
  g.angles = {0, 0.5, 1, 2};
  const std::vector<double> w = angle_weights(g);
  EXPECT_NEAR(w[0] + w[1] + w[2] + w[3], std::numbers::pi, 1e-12);
  EXPECT_GT(w[2], w[1]);
}

TEST(VolumeFit, StartHasTheMeanDensityOfTheBackprojection) {
  VoxelGrid<float> volume = test::truth(ball(), unit_grid(24)), start = unit_grid(24);
  sample_density(gaussians_of(volume, 1.5), start);
  const auto total = [](const VoxelGrid<float>& v) {
    double sum = 0;
    for (const float x : v.values) sum += double(x);
    return sum;
  };
  EXPECT_NEAR(total(start) / total(volume), 1, 0.02);
}

TEST(VolumeFit, IsNearerToTheTruthThanBackprojectionWithFewViews) {
  const ScanGeometry g = test::cone_scan(15, 28);
  const std::vector<ImageF> projections = test::scanned(g, test::closed_jar());
  VoxelGrid<float> volume = unit_grid(18), fitted = volume;
  const VoxelGrid<float> expected = test::truth(test::closed_jar(), volume);
  filtered_backprojection(g, projections, volume);
  std::vector<double> errors;
  const std::vector<Gaussian3f> set = fit_volume(g, projections, volume, gaussians_of(volume, 1.25), {.iterations = 150},
                                                 [&](const FitStep& s) { errors.push_back(s.error); });
  sample_density(set, fitted);
  EXPECT_GT(test::psnr(fitted, expected), test::psnr(volume, expected) + 2);
  EXPECT_LT(errors.back(), 0.5 * errors.front());
}

TEST(VolumeFit, SameBytesForAnyNumberOfThreads) {
  const ScanGeometry g = test::cone_scan(4, 20);
  const std::vector<ImageF> projections = test::scanned(g, ball());
  std::vector<std::vector<Gaussian3f>> sets;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    VoxelGrid<float> volume = unit_grid(10);
    filtered_backprojection(g, projections, volume);
    sets.push_back(fit_volume(g, projections, volume, gaussians_of(volume, 2), {.iterations = 6}));
  }
  set_thread_limit(0);
  ASSERT_FALSE(sets[0].empty());
  EXPECT_TRUE(sets[0] == sets[1]);
}

TEST(VolumeOutputs, TheSurfaceOfABallIsClosedAndHasItsVolume) {
  const VoxelGrid<float> volume = test::truth(ball(), unit_grid(32));
  const double iso = otsu_threshold(volume);
  EXPECT_GT(iso, 0.3);
  EXPECT_LT(iso, 1.7);
  const MeshReport report = mesh_report(density_surface(volume, 1));
  EXPECT_TRUE(report.closed());
  EXPECT_NEAR(report.volume, 4. / 3 * std::numbers::pi * 0.216, 0.03);
  EXPECT_TRUE(density_surface(volume, 5).faces.empty());
}

TEST(VolumeOutputs, NrrdStatesSizeSpacingAndUnit) {
  VoxelGrid<float> volume{.origin = {-1, -2, -3}, .cell = 0.5, .size = {4, 3, 2}, .values = {}};
  for (int i = 0; i < 24; ++i) volume.values.push_back(float(i));
  const TemporaryFolder folder;
  write_nrrd(folder.path() / "v.nrrd", volume, "mm");
  const std::string bytes = read_file(folder.path() / "v.nrrd");
  const size_t end = bytes.find("\n\n");
  ASSERT_EQ(bytes.size(), end + 2 + 24 * sizeof(float));
  EXPECT_TRUE(bytes.starts_with("NRRD0004\n"));
  for (const char* line : {"sizes: 4 3 2\n", "(0.5,0,0) (0,0.5,0) (0,0,0.5)", "\"mm\"", "space origin: (-0.75,-1.75,-2.75)"})
    EXPECT_NE(bytes.find(line), std::string::npos) << line;
  float last = 0;
  std::memcpy(&last, &bytes[bytes.size() - sizeof last], sizeof last);
  EXPECT_EQ(last, 23);
}

}  // namespace
}  // namespace vitrine
