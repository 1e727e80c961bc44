#include "core/observe/stereo/plane_fit.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/shape/box.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

constexpr double kWallDistance = 0.9;
constexpr double kDegrees = 57.29578;

// Upright, on a wall that cameras at the origin see in the direction `azimuth`; turned in the wall by `roll`.
Plane on_wall(double azimuth, double height, Vec2d half, double roll = 0) {
  const Vec3d normal{-std::cos(azimuth), -std::sin(azimuth), 0}, up{0, 0, 1}, right = cross(up, normal);
  const Vec3d u = std::cos(roll) * right + std::sin(roll) * up;
  return {-kWallDistance * normal + height * up, Mat3d{u, cross(normal, u), normal}, half};
}

// Cameras to both sides of the middle of the room, `aside` from it at most, that look at `target`.
template <class Meets>
std::vector<Silhouette> masks_from_the_room(int count, const Vec3d& target, const Meets& meets, double aside = 0.6) {
  std::vector<Silhouette> masks;
  for (int i = 0; i < count; ++i) {
    const double side = aside * (2.0 * i / (count - 1) - 1);
    const Vec3d eye{-0.7 + 0.25 * (i % 4), side, i % 3 == 0 ? 0.4 : i % 3 == 1 ? 0.1 : -0.2};
    const Vec3d forward = normalized(target - eye), right = normalized(cross(forward, Vec3d{0, 0, 1}));
    View view;
    view.intrinsics = {160, 120, 120, 120, 80, 60};
    view.cam_from_world = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, eye});
    masks.push_back(
        silhouette(view, mask_of_rays(view, [&](size_t, const Vec3d& from, const Vec3d& d) { return meets(from, d); })));
  }
  return masks;
}

std::vector<Silhouette> masks_of(const std::vector<Plane>& planes, int count = 12, const Vec3d& target = {0.9, 0, 0.1}) {
  return masks_from_the_room(count, target, [&](const Vec3d& eye, const Vec3d& d) {
    return std::ranges::any_of(planes, [&](const Plane& p) {
      const auto hit = p.intersect({eye, d});
      return hit && hit->element == 0;
    });
  });
}

struct Errors {
  double angle, corner;
};
Errors errors(const Plane& found, const Plane& truth) {
  Errors out{std::acos(std::clamp(dot(found.axes.c2, truth.axes.c2), -1.0, 1.0)) * kDegrees, 0};
  for (const Vec3d& p : found.outer_points()) {
    double nearest = 1e9;
    for (const Vec3d& q : truth.outer_points()) nearest = std::min(nearest, length(p - q));
    out.corner = std::max(out.corner, nearest);
  }
  return out;
}

constexpr double kPixel = 0.012;  // of a photo, at the wall

TEST(PlaneFit, FindsARectangleOnAWallFromItsMasksAlone) {
  const Plane truth = on_wall(0.2, 0.1, {0.25, 0.18});
  const auto found = fit_planes(masks_of({truth}), {}, {});
  ASSERT_EQ(found.size(), 1u);
  const Errors off = errors(found[0].plane, truth);
  fmt::print("{:.2f} deg, corners {:.4f} off, agreement {:.4f}\n", off.angle, off.corner, found[0].agreement);
  EXPECT_LT(off.angle, 1.0);
  EXPECT_LT(off.corner, kPixel);
  EXPECT_GT(found[0].agreement, 0.97);
}

TEST(PlaneFit, ThingsInFrontOfItAreOutvoted) {
  const Plane truth = on_wall(0, 0.1, {0.25, 0.2});
  std::vector<Silhouette> masks = masks_of({truth});
  for (size_t v = 0; v < masks.size(); ++v)
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        const bool post = x >= 70 && x < 78 && y > 60, shelf = v % 4 == 0 && y > 55;
        if (post || shelf) masks[v].value.at(x, y) = 0;
      }
  const auto found = fit_planes(masks, {}, {});
  ASSERT_EQ(found.size(), 1u);
  const Errors off = errors(found[0].plane, truth);
  fmt::print("{:.2f} deg, corners {:.4f} off, agreement {:.4f}\n", off.angle, off.corner, found[0].agreement);
  EXPECT_LT(off.angle, 2.0);
  EXPECT_LT(off.corner, 2 * kPixel);
}

TEST(PlaneFit, TwoOnTwoWallsAreTwo) {
  const std::vector<Plane> truth{on_wall(0.5, 0.1, {0.2, 0.15}), on_wall(-0.5, 0.1, {0.15, 0.22})};
  const auto found = fit_planes(masks_of(truth), {}, {});
  ASSERT_EQ(found.size(), 2u);
  for (const Plane& t : truth) {
    const Errors off = errors(found[0].plane.centre.y * t.centre.y > 0 ? found[0].plane : found[1].plane, t);
    EXPECT_LT(off.angle, 1.5);
    EXPECT_LT(off.corner, 1.5 * kPixel);
  }
}

// Every photo cuts a side of it off, so that no photo shows four corners; sparse points on the wall say where it hangs.
TEST(PlaneFit, SparsePointsFindWhatNoPhotoShowsWhole) {
  const Plane truth = on_wall(0, 0.1, {0.55, 0.2});
  std::vector<Silhouette> masks;
  for (const double aim : {0.55, -0.55}) {
    const auto half = masks_of({truth}, 9, {0.9, aim, 0.1});
    masks.insert(masks.end(), half.begin(), half.end());
  }
  EXPECT_TRUE(fit_planes(masks, {}, {}).empty()) << "no photo shows four corners";
  std::vector<Vec3d> points;
  Rng rng(7);
  const auto random = [&] { return 2 * rng.uniform_double() - 1; };
  for (int i = 0; i < 240; ++i) {
    const Vec3d on = truth.centre + 0.65 * random() * truth.axes.c0 + 0.28 * random() * truth.axes.c1;
    points.push_back(i % 3 == 0 ? on + (0.4 * (1 + random())) * (-truth.axes.c2) : on + 0.003 * random() * truth.axes.c2);
  }
  const auto found = fit_planes(masks, points, {.inside_weight = 0.3});
  ASSERT_EQ(found.size(), 1u);
  const Errors off = errors(found[0].plane, truth);
  fmt::print("{:.2f} deg, corners {:.4f} off, agreement {:.4f}\n", off.angle, off.corner, found[0].agreement);
  EXPECT_LT(off.angle, 1.5);
  EXPECT_LT(off.corner, 2 * kPixel);
}

TEST(PlaneFit, ClosedObjectsAreNone) {
  const Vec3d at{0.3, 0, 0.1};
  const Box box{Mat3d::identity(), at - Vec3d{0.2, 0.2, 0.2}, at + Vec3d{0.2, 0.2, 0.2}};
  const auto ball =
      masks_from_the_room(14, at, [&](const Vec3d& eye, const Vec3d& d) { return meets_ball(at, 0.2, eye, normalized(d)); });
  const auto block =
      masks_from_the_room(14, at, [&](const Vec3d& eye, const Vec3d& d) { return box.crossing(eye, d).has_value(); });
  for (const auto& [name, masks] : {std::pair("ball", &ball), std::pair("box", &block)}) {
    for (const PlaneFit& f : fit_planes(*masks, {}, {.least = 0})) fmt::print("{}: agreement {:.4f}\n", name, f.agreement);
    EXPECT_TRUE(fit_planes(*masks, {}, {}).empty()) << name;
  }
}

// From a short arc a rectangle agrees with a case to .95: a box agrees better.
TEST(PlaneFit, WhatABoxFitsClearlyBetterIsNone) {
  const Vec3d at{0.3, 0, 0.1};
  const Box box{Mat3d::identity(), at - Vec3d{0.2, 0.2, 0.2}, at + Vec3d{0.2, 0.2, 0.2}};
  const auto masks = masks_from_the_room(
      14, at, [&](const Vec3d& eye, const Vec3d& d) { return box.crossing(eye, d).has_value(); }, 0.15);
  const Plane middle{at, Mat3d{{0, -1, 0}, {0, 0, 1}, {-1, 0, 0}}, {0.2, 0.2}};
  const auto anyway = refined_plane(masks, middle, 0);
  ASSERT_TRUE(anyway);
  EXPECT_GT(anyway->agreement, kLeastPlaneAgreement) << "the test tries nothing otherwise";
  EXPECT_TRUE(fit_planes(masks, {}, {}).empty());
}

TEST(PlaneFit, SmallOnesAndThoseOfFewPhotosAreNone) {
  EXPECT_TRUE(fit_planes(masks_of({on_wall(0, 0.1, {0.02, 0.02})}), {}, {}).empty());
  EXPECT_TRUE(fit_planes(masks_of({on_wall(0, 0.1, {0.25, 0.18})}, 3), {}, {}).empty());
  EXPECT_TRUE(fit_planes({}, {}, {}).empty());
}

TEST(PlaneFit, IsTheSameForAnyNumberOfThreads) {
  const auto masks = masks_of({on_wall(0.2, 0.1, {0.25, 0.18})});
  const auto numbers = [&](int threads) {
    set_thread_limit(threads);
    const Plane p = fit_planes(masks, {}, {}).at(0).plane;
    set_thread_limit(0);
    return std::array<double, 8>{p.centre.x, p.centre.y, p.centre.z, p.axes.c2.x, p.axes.c2.y, p.axes.c2.z, p.half.x, p.half.y};
  };
  EXPECT_EQ(numbers(1), numbers(4));
}

}  // namespace
}  // namespace vitrine
