// Meshes of free forms from exact silhouettes.
#include "core/observe/stereo/shape_fit.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/parallel.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

constexpr double kRoundEllipsoid = 2 * std::numbers::pi;
const Vec3d kSemiAxes{0.3, 0.2, 0.15}, kEllipsoid{0.02, -0.03, 0.01};  // of an ellipsoid: no box, no surface of revolution

bool meets_ellipsoid(const Vec3d& eye, const Vec3d& d) {
  Vec3d o = eye - kEllipsoid, way = d;
  for (size_t c = 0; c < 3; ++c) o[c] /= kSemiAxes[c], way[c] /= kSemiAxes[c];
  return meets_ball({0, 0, 0}, 1, o, normalized(way));
}

// A ball of the directions of a divided octahedron, carried to the ellipsoid and `bulge` beyond it.
TriMesh bulging(double bulge, int divisions = 3) {
  TriMesh ball;
  ball.positions = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  ball.faces = {{4, 0, 2}, {4, 2, 1}, {4, 1, 3}, {4, 3, 0}, {5, 2, 0}, {5, 1, 2}, {5, 3, 1}, {5, 0, 3}};
  for (int k = 0; k < divisions; ++k) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
    const auto middle = [&](uint32_t a, uint32_t b) {
      const auto [it, added] = middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(ball.positions.size()));
      if (added) ball.positions.push_back(normalized(ball.positions[a] + ball.positions[b]));
      return it->second;
    };
    std::vector<std::array<uint32_t, 3>> faces;
    for (const auto& [a, b, c] : ball.faces) {
      const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      faces.insert(faces.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    ball.faces = std::move(faces);
  }
  for (Vec3f& p : ball.positions)
    for (size_t c = 0; c < 3; ++c)
      p[c] = static_cast<float>(
          kEllipsoid[c] + (kSemiAxes[c] + bulge * (1 + 0.5 * std::sin(17 * double(p[0]) + 11 * double(p[2])))) * double(p[c]));
  return ball;
}

struct EllipsoidErrors {
  double degrees = 0, away = 0;  // mean angle of the normals; mean distance from the ellipsoid
};
EllipsoidErrors ellipsoid_errors(const TriMesh& mesh) {
  EllipsoidErrors sum;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    Vec3d n{}, p = cast<double>(mesh.positions[v]) - kEllipsoid;
    double level = 0;
    for (size_t c = 0; c < 3; ++c) n[c] = p[c] / (kSemiAxes[c] * kSemiAxes[c]), level += p[c] * n[c];
    sum.away += std::abs(level - 1) / (2 * length(n));
    sum.degrees += std::acos(std::clamp(dot(normalized(n), cast<double>(mesh.normals[v])), -1.0, 1.0)) * 57.29578;
  }
  return {sum.degrees / double(mesh.positions.size()), sum.away / double(mesh.positions.size())};
}

TEST(MeshFit, FindsAnEllipsoidFromABulgingStart) {
  const auto masks = silhouettes_of_rays(30, kRoundEllipsoid, meets_ellipsoid);
  const MeshFit before = fit_mesh(masks, bulging(0.04), {.rounds = 0}), fit = fit_mesh(masks, bulging(0.04));
  const EllipsoidErrors then = ellipsoid_errors(before.mesh), now = ellipsoid_errors(fit.mesh);
  fmt::print("normals {:.1f}, then {:.2f} deg; {:.4f}, then {:.4f} off\n", then.degrees, now.degrees, then.away, now.away);
  EXPECT_GT(then.degrees, 10);
  EXPECT_LT(now.degrees, 3);
  EXPECT_LT(now.away, 0.004) << "a pixel is 0.011 wide there";
  EXPECT_LT(fit.residual, before.residual / 3);
  EXPECT_GT(fit.contacts, 0.6);
}

// In a third of the photos something in front cuts a half of the silhouette away; in others something of the class stands beside.
TEST(MeshFit, FollowsTheMostOfThePhotos) {
  auto masks = silhouettes_of_rays(30, kRoundEllipsoid, meets_ellipsoid);
  for (size_t i = 0; i < masks.size(); ++i)
    for (int y = 0; y < masks[i].value.height(); ++y)
      for (int x = 0; x < masks[i].value.width(); ++x) {
        if (i % 3 == 0 && x < 45) masks[i].value.at(x, y) = 0;
        if (i % 5 == 1 && y > 50) masks[i].value.at(x, y) = 1;
      }
  const EllipsoidErrors now = ellipsoid_errors(fit_mesh(masks, bulging(0.03)).mesh);
  fmt::print("normals {:.2f} deg, {:.4f} off\n", now.degrees, now.away);
  EXPECT_LT(now.degrees, 5);
  EXPECT_LT(now.away, 0.008);
}

TEST(MeshFit, WhatPhotosDoNotSayMovesNothing) {
  auto masks = silhouettes_of_rays(12, kRoundEllipsoid, meets_ellipsoid);
  for (Silhouette& m : masks) std::ranges::fill(m.value.data(), -1.f);
  const MeshFit fit = fit_mesh(masks, bulging(0, 2), {.rounds = 3});
  EXPECT_EQ(fit.contacts, 0);
  EXPECT_EQ(fit.mesh.positions, bulging(0, 2).positions);
  EXPECT_TRUE(fit_mesh(masks, {}).mesh.faces.empty());
}

TEST(MeshFit, IsTheSameForAnyNumberOfThreads) {
  const auto masks = silhouettes_of_rays(18, kRoundEllipsoid, meets_ellipsoid);
  const auto fitted = [&](int threads) {
    set_thread_limit(threads);
    const MeshFit fit = fit_mesh(masks, bulging(0.03, 2), {.rounds = 6});
    set_thread_limit(0);
    return fit.mesh.positions;
  };
  EXPECT_EQ(fitted(1), fitted(4));
}

}  // namespace
}  // namespace vitrine
