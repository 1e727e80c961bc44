// Volumes of phantoms with known density: projections of the geometry, filtered backprojection, the fit against it and SIRT, the
// surface and the NRRD file.
#include <cstring>

#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "stages/tomography/tomography.h"
#include "stages/tomography/total_variation.h"
#include "stages/tomography/voxel_fit.h"
#include "tests/stages/tomography/filtered_backprojection.h"
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
    test::filtered_backprojection(g, test::scanned(g, ball()), volume);
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
  for (const double w : test::angle_weights(g)) EXPECT_NEAR(w, std::numbers::pi / 4, 1e-12);
  g.angles = {0, 0.5, 1, 2};
  const std::vector<double> w = test::angle_weights(g);
  EXPECT_NEAR(w[0] + w[1] + w[2] + w[3], std::numbers::pi, 1e-12);
  EXPECT_GT(w[2], w[1]);
}

// The total variation of a cube in a grid is that of its faces; small jumps vanish, large ones stay.
TEST(TotalVariation, RemovesNoiseAndKeepsEdges) {
  VoxelGrid<float> expected = unit_grid(20), noisy;
  expected.values.assign(expected.count(), 0.f);
  expected.each_in_order([&](int x, int y, int z) {
    const bool inside = std::min({x, y, z}) >= 5 && std::max({x, y, z}) < 15;
    expected.values[expected.index(x, y, z)] = inside ? 1.f : 0.f;
  });
  noisy = expected;
  Rng rng(3, 1);
  for (float& v : noisy.values) v += 0.1f * rng.normal();
  const double before = test::psnr(noisy, expected);
  TotalVariation smoother(noisy);
  smoother.reduce(noisy, 0.1f);
  EXPECT_GT(test::psnr(noisy, expected), before + 4);
  EXPECT_GT(noisy.at(10, 10, 10), 0.9);
  EXPECT_GT(noisy.at(5, 10, 10) - noisy.at(4, 10, 10), 0.7);
}

// The acceptance of the stage, small: 3 dB over filtered backprojection, 1 dB over as many rounds of SIRT (which take longer: its
// round passes every ray twice), without noise and with that of 10 000 photons a pixel.
TEST(VoxelFit, IsNearerToTheTruthThanBackprojectionAndSirt) {
  for (const double photons : {0., 1e4}) {
    const ScanGeometry g = test::cone_scan(25, 48);
    const std::vector<ImageF> projections = test::counted(test::scanned(g, test::head()), photons);
    VoxelGrid<float> backprojected = unit_grid(32), fitted = backprojected, sirt = backprojected;
    const VoxelGrid<float> expected = test::truth(test::head(), fitted);
    test::filtered_backprojection(g, projections, backprojected);
    std::vector<double> errors;
    fit_voxels(g, projections, fitted, {}, [&](const FitRound& r) {
      if (r.share == 1) errors.push_back(r.error);
    });
    test::sirt(g, projections, int(errors.size()), sirt);
    const double ours = test::psnr(fitted, expected);
    EXPECT_GT(ours, test::psnr(backprojected, expected) + 3) << photons;
    EXPECT_GT(ours, test::psnr(sirt, expected) + 1) << photons;
    EXPECT_LT(errors.back(), 0.5 * errors.front());
  }
}

TEST(VoxelFit, ProjectionsOfTheTruthAreThoseOfThePhantom) {
  const ScanGeometry g = test::parallel_scan(3, 40);
  const std::vector<ImageF> expected = test::scanned(g, ball()), seen = projected(g, test::truth(ball(), unit_grid(40)));
  for (size_t i = 0; i < seen.size(); ++i)
    EXPECT_NEAR(double(seen[i].at(20, 20)), double(expected[i].at(20, 20)), 0.02 * double(expected[i].at(20, 20)));
}

TEST(VoxelFit, SameBytesForAnyNumberOfThreads) {
  const ScanGeometry g = test::cone_scan(30, 20);
  const std::vector<ImageF> projections = test::scanned(g, ball());
  std::vector<std::vector<float>> volumes;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    VoxelGrid<float> volume = unit_grid(10);
    fit_voxels(g, projections, volume, {.rounds = 2});
    volumes.push_back(volume.values);
  }
  set_thread_limit(0);
  EXPECT_TRUE(volumes[0] == volumes[1]);
}

// Stopped in its first round, where nothing is saved yet, and in later ones; with a damaged file it begins again.
TEST(VoxelFit, GoesOnWhereItWasStopped) {
  struct Stopped {};
  const ScanGeometry g = test::cone_scan(45, 20);  // two projections a step
  const std::vector<ImageF> projections = test::scanned(g, ball());
  const TemporaryFolder folder;
  VoxelFitDesc desc{.rounds = 3};
  VoxelGrid<float> whole = unit_grid(10), volume = whole;
  fit_voxels(g, projections, whole, desc);
  desc.checkpoint = folder.path() / "fit.checkpoint";
  std::vector<int> begun;
  for (const auto& [round, share] : {std::pair{1, 0.4}, {1, 1.}, {2, 0.3}, {3, 0.9}}) {
    bool first = true;
    EXPECT_THROW(fit_voxels(g, projections, volume, desc,
                            [&](const FitRound& r) {
                              if (std::exchange(first, false)) begun.push_back(r.round);
                              if (r.round == round && r.share >= share) throw Stopped{};
                            }),
                 Stopped);
  }
  EXPECT_EQ(begun, (std::vector{1, 1, 1, 2}));
  fit_voxels(g, projections, volume, desc, [&](const FitRound& r) { begun.push_back(r.round); });
  EXPECT_EQ(begun[4], 3);
  EXPECT_TRUE(volume.values == whole.values);
  write_file(desc.checkpoint, read_file(desc.checkpoint) + "x");
  fit_voxels(g, projections, volume, desc);
  EXPECT_TRUE(volume.values == whole.values);
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
