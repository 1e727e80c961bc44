#include "core/observe/stereo/box_fit.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

constexpr double kAround = 2 * std::numbers::pi, kCaseTurn = 0.35;
const Vec3d kCaseHalf{0.2, 0.14, 0.28};
const Bounds3 kAbout{{-0.3, -0.3, -0.35}, {0.3, 0.3, 0.35}};

std::vector<Silhouette> case_masks(int count) {
  return silhouettes_of_rays(count, kAround,
                             [](const Vec3d& eye, const Vec3d& d) { return meets_box(kCaseHalf, kCaseTurn, eye, d); });
}

// Largest angle between a face and the nearest true one, degrees, and largest distance of a corner from the nearest true one.
std::pair<double, double> errors(const Box& box) {
  const double c = std::cos(kCaseTurn), s = std::sin(kCaseTurn);
  double angle = 0, distance = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const Vec3d n = box.axes.column(axis);
    const double nearest = std::max({std::abs(c * n.x + s * n.y), std::abs(c * n.y - s * n.x), std::abs(n.z)});
    angle = std::max(angle, std::acos(std::min(1.0, nearest)) * 57.29578);
  }
  for (size_t i = 0; i < 8; ++i) {
    double nearest = 1e9;
    for (size_t j = 0; j < 8; ++j) {
      const Vec3d local{j & 1 ? kCaseHalf.x : -kCaseHalf.x, j & 2 ? kCaseHalf.y : -kCaseHalf.y,
                        j & 4 ? kCaseHalf.z : -kCaseHalf.z};
      const Vec3d corner{c * local.x - s * local.y, s * local.x + c * local.y, local.z};
      nearest = std::min(nearest, length(box.corner(i) - corner));
    }
    distance = std::max(distance, nearest);
  }
  return {angle, distance};
}

TEST(BoxFit, FindsTheFacesOfACaseToAFractionOfAPixel) {
  for (int count : {4, 24}) {
    const auto fit = fit_box(case_masks(count), kAbout);
    ASSERT_TRUE(fit) << count;
    const auto [angle, distance] = errors(fit->box);
    fmt::print("{} photos: {:.2f} deg, corners {:.4f} off, agreement {:.4f}\n", count, angle, distance, fit->agreement);
    EXPECT_LT(angle, count > 10 ? 0.5 : 1.0);
    EXPECT_LT(distance, 0.011);  // a pixel is 0.011 wide there
  }
}

TEST(BoxFit, SomethingInFrontOfItInAFewPhotosIsOutvoted) {
  std::vector<Silhouette> masks = case_masks(24);
  for (size_t v = 0; v < masks.size(); v += 5)
    for (int y = 0; y < 80; ++y)
      for (int x = 30; x < 46; ++x) masks[v].value.at(x, y) = 0;
  const auto fit = fit_box(masks, kAbout);
  ASSERT_TRUE(fit);
  EXPECT_LT(errors(fit->box).first, 1.0);
  EXPECT_LT(errors(fit->box).second, 0.011);
}

TEST(BoxFit, BallsAndCylindersAreNoBoxes) {
  const auto ball =
      silhouettes_of_rays(24, kAround, [](const Vec3d& eye, const Vec3d& d) { return meets_ball({}, 0.25, eye, d); });
  const auto jar =
      silhouettes_of_rays(24, kAround, [](const Vec3d& eye, const Vec3d& d) { return meets_cylinder(0.2, 0.28, eye, d); });
  for (const auto& [name, masks] : {std::pair("ball", ball), std::pair("jar", jar)}) {
    const auto anyway = fit_box(masks, kAbout, 0);
    ASSERT_TRUE(anyway);
    fmt::print("{}: agreement {:.4f}\n", name, anyway->agreement);
    EXPECT_FALSE(fit_box(masks, kAbout)) << name;
  }
}

TEST(BoxFit, OutlinesAreThoseOfTheMasks) {
  const std::vector<Silhouette> masks = case_masks(12);
  const auto fit = fit_box(masks, kAbout);
  ASSERT_TRUE(fit);
  for (const Silhouette& m : masks) {
    const std::vector<uint8_t> inside = silhouette_mask(fit->box, m.view);
    size_t differ = 0, all = 0;
    for (size_t i = 0; i < inside.size(); ++i) differ += inside[i] != (m.value.data()[i] >= 0.5f), all += inside[i];
    EXPECT_LT(differ, all / 20);
  }
}

TEST(BoxFit, WithoutAMaskThereIsNoBox) {
  std::vector<Silhouette> masks = case_masks(3);
  for (Silhouette& m : masks) std::ranges::fill(m.value.data(), 0.f);
  EXPECT_FALSE(fit_box(masks, kAbout));
  EXPECT_FALSE(fit_box({}, kAbout));
  EXPECT_FALSE(fit_box(case_masks(3), {}));
}

}  // namespace
}  // namespace vitrine
