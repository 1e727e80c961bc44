#include "core/observe/stereo/revolution_fit.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

double vase_profile(double h) { return 0.13 + 0.03 * std::cos(9 * h); }

// Its radii times `wider(i)`.
template <class Wider>
SurfaceOfRevolution vase_with(const Wider& wider) {
  std::vector<double> radii;
  for (int i = 0; i <= 40; ++i) radii.push_back(wider(i) * vase_profile(-0.2 + 0.01 * i));
  return revolved({0.02, -0.01, 0}, normalized(Vec3d{0.05, 0.02, 1}), -0.2, 0.01, radii);
}
SurfaceOfRevolution true_vase() {
  return vase_with([](int) { return 1.0; });
}

// A polished vase before a wall of tiles, in a room that it mirrors: as many edges inside as outside.
std::vector<EdgePhoto> photos_of(const SurfaceOfRevolution& vase, int count) {
  std::vector<EdgePhoto> photos;
  for (const Silhouette& m : silhouettes_of_rays(count, 2 * std::numbers::pi, [](const Vec3d&, const Vec3d&) { return false; })) {
    EdgePhoto photo{m.view, {}};
    photo.view.intrinsics = {288, 240, 270, 270, 144, 120};
    const Intrinsics& k = photo.view.intrinsics;
    photo.srgb = ImageF(k.width, k.height, 3);
    const Vec3d eye = photo.view.centre_in_world();
    const auto tiles = [](const Vec3d& d) {  // of a direction
      const Vec3d n = normalized(d);
      return int(std::floor(7 * std::atan2(n.y, n.x))) + int(std::floor(7 * n.z + 50));
    };
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        Vec3d direction = normalized(photo.view.ray(x + 0.5, y + 0.5));
        const auto hit = vase.intersect({eye, direction});
        if (hit) {
          const Vec3d n = vase.nearest(eye + hit->t * direction).normal;
          direction = direction - 2 * dot(direction, n) * n;
        }
        const int tile = tiles(direction);
        for (int c = 0; c < 3; ++c)
          photo.srgb.at(x, y, c) = (hit ? 0.9f : 1.f) * (0.25f + 0.12f * float((((tile * (c + 3)) % 5) + 5) % 5));
      }
    photos.push_back(std::move(photo));
  }
  return photos;
}

double off_at(const SurfaceOfRevolution& vase, const SurfaceOfRevolution& truth) {
  double worst = 0;
  for (double h = -0.15; h < 0.16; h += 0.02)
    for (double a = 0; a < 6; a += 0.5) {
      const Vec3d u = normalized(cross(truth.axis, Vec3d{1, 0, 0})), v = cross(truth.axis, u);
      const Vec3d p = truth.origin + h * truth.axis + vase_profile(h) * (std::cos(a) * u + std::sin(a) * v);
      worst = std::max(worst, length(vase.nearest(p).position - p));
    }
  return worst;
}

TEST(RevolutionEdges, APolishedVaseIsDrawnToItsSilhouette) {
  const SurfaceOfRevolution truth = true_vase();
  SurfaceOfRevolution start = vase_with([](int i) { return 1.04 + 0.03 * std::sin(0.3 * i); });
  start.origin = truth.origin + Vec3d{0.008, -0.006, 0};
  start.axis = normalized(truth.axis + Vec3d{-0.04, 0.03, 0});
  const SurfaceOfRevolution drawn = drawn_to_edges(start, photos_of(truth, 24));
  fmt::print("off {:.4f}, drawn {:.4f}\n", off_at(start, truth), off_at(drawn, truth));
  EXPECT_GT(off_at(start, truth), 0.015);
  EXPECT_LT(off_at(drawn, truth), 0.003);  // a pixel is 0.0037 wide there
}

TEST(RevolutionEdges, WithoutPhotosItStaysWhereItIs) {
  const SurfaceOfRevolution start = true_vase(), same = drawn_to_edges(start, photos_of(start, 4));
  ASSERT_EQ(same.profile.size(), start.profile.size());
  for (size_t i = 0; i < start.profile.size(); ++i) EXPECT_EQ(same.profile[i].x, start.profile[i].x);
  EXPECT_EQ(length(same.origin - start.origin), 0);
}

}  // namespace
}  // namespace vitrine
