#include "core/observe/stereo/revolution_fit.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/observe/stereo/shape_fit.h"
#include "core/observe/stereo/visual_hull.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

const Vec3d kVaseFoot{0.03, -0.02, -0.25};
constexpr double kVaseHeight = 0.5, kVaseVoxel = 0.008, kFullTurn = 2 * std::numbers::pi;

double vase_radius(double h) { return 0.13 + 0.05 * std::cos(9 * h); }
double vase_slope(double h) { return -0.45 * std::sin(9 * h); }

struct Vase {
  double lean = 0;  // of its axis towards x, radians
  bool handle = false;
  // As it stands, from as if it did not lean, and back.
  Vec3d leaning(const Vec3d& p) const {
    const double c = std::cos(lean), s = std::sin(lean);
    return {c * p.x + s * p.z, p.y, c * p.z - s * p.x};
  }
  bool inside(const Vec3d& world) const {
    const Vec3d p = Vase{-lean}.leaning(world - kVaseFoot);
    if (handle && std::abs(p.y) < 0.02 && p.x > 0 && p.x < 0.24 && p.z > 0.2 && p.z < 0.26) return true;
    return p.z > 0 && p.z < kVaseHeight && std::hypot(p.x, p.y) < vase_radius(p.z);
  }
  std::vector<Silhouette> masks(int count) const {
    return silhouettes_of_rays(count, kFullTurn, [&](const Vec3d& eye, const Vec3d& d) {
      for (int i = 0; i < 240; ++i)
        if (inside(eye + (0.5 + i / 240.0) * d)) return true;
      return false;
    });
  }
  // Of its wall, as a hull would have it, `bulge` too wide.
  std::vector<ShapePoint> surface(double bulge) const {
    std::vector<ShapePoint> points;
    for (double h = 0; h < kVaseHeight; h += kVaseVoxel)
      for (double a = 0; a < kFullTurn; a += 0.05) {
        const double r = vase_radius(h) + bulge, c = std::cos(a), s = std::sin(a);
        points.push_back({kVaseFoot + leaning({r * c, r * s, h}), leaning(normalized(Vec3d{c, s, -vase_slope(h)}))});
      }
    return points;
  }
};

// Mean angle between the normals of the solid and the true ones over the middle of the height, degrees, and mean distance.
std::pair<double, double> vase_errors(const SurfaceOfRevolution& solid) {
  double angle = 0, distance = 0;
  int count = 0;
  for (double h = 0.06; h < 0.45; h += 0.03)
    for (double a = 0; a < 6; a += 0.5) {
      const Vec3d p = kVaseFoot + Vec3d{vase_radius(h) * std::cos(a), vase_radius(h) * std::sin(a), h};
      const Vec3d n = normalized(Vec3d{std::cos(a), std::sin(a), -vase_slope(h)});
      const ShapePoint found = solid.nearest(p);
      angle += std::acos(std::clamp(dot(found.normal, n), -1.0, 1.0)) * 57.29578;
      distance += length(found.position - p);
      ++count;
    }
  return {angle / count, distance / count};
}

TEST(RevolutionFit, FindsAVaseWithAndWithoutAHandle) {
  for (bool handle : {false, true}) {
    const Vase vase{.handle = handle};
    const auto solids = surfaces_of_revolution(vase.masks(24), vase.surface(0.006), kVaseVoxel);
    ASSERT_EQ(solids.size(), 1u) << handle;
    const auto [angle, distance] = vase_errors(solids[0]);
    fmt::print("handle {}: normals {:.2f} deg, {:.4f} off\n", handle, angle, distance);
    EXPECT_LT(angle, 6);
    EXPECT_LT(distance, 0.004);  // a pixel is 0.011 wide there
  }
}

TEST(RevolutionFit, ItsAxisMayLean) {
  const Vase vase{.lean = 0.2};
  const auto solids = surfaces_of_revolution(vase.masks(24), vase.surface(0), kVaseVoxel);
  ASSERT_EQ(solids.size(), 1u);
  EXPECT_NEAR(solids[0].axis.x, std::sin(0.2), 0.02);
  EXPECT_NEAR(solids[0].axis.y, 0, 0.02);
}

TEST(RevolutionFit, SomethingInFrontOfItInAFewPhotosIsOutvoted) {
  const Vase vase;
  std::vector<Silhouette> masks = vase.masks(24);
  for (size_t v : {3, 14})
    for (int y = 0; y < 80; ++y)
      for (int x = 40; x < 52; ++x) masks[v].value.at(x, y) = 0;
  const auto solids = surfaces_of_revolution(masks, vase.surface(0), kVaseVoxel);
  ASSERT_EQ(solids.size(), 1u);
  EXPECT_LT(vase_errors(solids[0]).first, 6);
}

TEST(RevolutionFit, EveryThingOfAClassIsLookedAtAlone) {
  const Vec3d ball_at{0.05, 0.28, 0};
  const Vase vase;
  std::vector<Silhouette> masks = vase.masks(24);
  const auto balls =
      silhouettes_of_rays(24, kFullTurn, [&](const Vec3d& eye, const Vec3d& d) { return meets_ball(ball_at, 0.07, eye, d); });
  for (size_t v = 0; v < masks.size(); ++v)
    for (size_t i = 0; i < masks[v].value.data().size(); ++i)
      masks[v].value.data()[i] = std::max(masks[v].value.data()[i], balls[v].value.data()[i]);
  std::vector<ShapePoint> surface = vase.surface(0);
  for (double h = -0.98; h < 1; h += 0.08)
    for (double a = 0; a < kFullTurn; a += 0.09) {
      const double r = std::sqrt(1 - h * h);
      const Vec3d n{r * std::cos(a), r * std::sin(a), h};
      surface.push_back({ball_at + 0.07 * n, n});
    }
  const auto solids = surfaces_of_revolution(masks, surface, kVaseVoxel);
  ASSERT_EQ(solids.size(), 2u);
  const bool first = solids[0].profile.back().y - solids[0].profile[0].y < 0.3;  // the ball
  EXPECT_LT(vase_errors(solids[first ? 1 : 0]).first, 6);
  EXPECT_NEAR(solids[first ? 0 : 1].largest_radius(), 0.07, 0.006);
}

TEST(RevolutionFit, ALongThingIsNone) {
  const Vec3d half{0.3, 0.08, 0.1};
  const auto masks =
      silhouettes_of_rays(24, kFullTurn, [&](const Vec3d& eye, const Vec3d& d) { return meets_box(half, 0, eye, d); });
  std::vector<ShapePoint> surface;
  for (double z = -half.z; z < half.z; z += kVaseVoxel) {
    for (double x = -half.x; x < half.x; x += kVaseVoxel)
      for (double side : {-1.0, 1.0}) surface.push_back({{x, side * half.y, z}, {0, side, 0}});
    for (double y = -half.y; y < half.y; y += kVaseVoxel)
      for (double side : {-1.0, 1.0}) surface.push_back({{side * half.x, y, z}, {side, 0, 0}});
  }
  EXPECT_TRUE(surfaces_of_revolution(masks, surface, kVaseVoxel).empty());
  EXPECT_TRUE(surfaces_of_revolution({}, surface, kVaseVoxel).empty());
  EXPECT_TRUE(surfaces_of_revolution(masks, {}, kVaseVoxel).empty());
  std::vector<Silhouette> black = Vase{}.masks(6);
  for (Silhouette& m : black) std::ranges::fill(m.value.data(), 0.f);
  EXPECT_TRUE(surfaces_of_revolution(black, Vase{}.surface(0), kVaseVoxel).empty());
}

TEST(RevolutionFit, ItsSilhouetteIsWhatRaysMeet) {
  const SurfaceOfRevolution can = revolved({}, {0, 0, 1}, -0.25, 0.1, std::vector(6, 0.2));
  for (const Silhouette& m :
       silhouettes_of_rays(6, kFullTurn, [&](const Vec3d&eye, const Vec3d&d) { return meets_cylinder(0.2, 0.25, eye, d); })) {
    const std::vector<uint8_t> inside = silhouette_mask(can, m.view);
    for (size_t i = 0; i < inside.size(); ++i) ASSERT_EQ(inside[i] != 0, m.value.data()[i] > 0) << i;
  }
  // A cone that widens and narrows: nothing at its tips.
  const SurfaceOfRevolution top = revolved({0.1, 0, 0}, {0, 0, 1}, -0.2, 0.2, std::vector{0.001, 0.2, 0.001});
  View view;
  view.intrinsics = {80, 80, 80, 80, 40, 40};
  view.cam_from_world = {Mat3d::identity(), {-0.1, 0, 1}};  // looks along +z from below
  const std::vector<uint8_t> disc = silhouette_mask(top, view);
  for (int y = 0; y < 80; ++y)
    for (int x = 0; x < 80; ++x) {
      const double r = std::hypot(x - 39.5, y - 39.5);
      if (std::abs(r - 16) <= 1) continue;
      ASSERT_EQ(disc[size_t(80 * y + x)] != 0, r < 16) << x << " " << y;
    }
}

// Against its own normals: those of a hull of voxels waver.
TEST(RevolutionFit, ItsNormalsAreBetterThanThoseOfAVisualHull) {
  const Vase vase;
  const std::vector<Silhouette> masks = vase.masks(24);
  const VisualHull hull(masks, {.resolution = 64, .rule = {.outlier_share = 0}});
  const FittedShapes fits = fit_shapes(masks, hull);
  ASSERT_FALSE(fits.box);
  ASSERT_EQ(fits.solids.size(), 1u);
  const SurfaceOfRevolution& surface = fits.solids[0];
  double of_hull = 0, of_fit = 0;
  int count = 0;
  for (double h = 0.1; h < 0.4; h += 0.02)
    for (double a = 0; a < 6; a += 0.3) {
      const Vec3d out{std::cos(a), std::sin(a), 0}, eye = kVaseFoot + Vec3d{0, 0, h} + 0.9 * out;
      const auto carved = hull.first_hit(eye, -out);
      const auto fitted = surface.intersect({eye, -out});
      if (!carved || !fitted) continue;
      const Vec3d n = normalized(Vec3d{out.x, out.y, -vase_slope(h)});
      const auto degrees = [&](const Vec3d& m) { return std::acos(std::clamp(dot(m, n), -1.0, 1.0)) * 57.29578; };
      of_hull += degrees(carved->normal), of_fit += degrees(fitted->normal), ++count;
    }
  EXPECT_GT(count, 250);
  EXPECT_LT(of_fit / count, 6);
  EXPECT_LT(of_fit, 0.6 * of_hull);
}

}  // namespace
}  // namespace vitrine
