// Pieces of space that nothing explains: balls that cameras in a ring see before a floor.
#include "core/observe/stereo/unexplained_pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/core/observe/stereo/textured_room.h"

namespace vitrine {
namespace {

constexpr int kCameras = 16;
constexpr double kFloorHeight = -0.4, kPieceRadius = 0.15;

struct Scene {
  std::vector<View> views;
  std::vector<Explanation> explained;

  explicit Scene(std::span<const Vec3d> balls) {
    for (int v = 0; v < kCameras; ++v) {
      const double azimuth = 2 * std::numbers::pi * v / kCameras;
      View view;
      view.intrinsics = {96, 72, 110, 110, 48, 36};
      view.cam_from_world = textured_room::looking_at({std::cos(azimuth), std::sin(azimuth), 0.4}, {0, 0, -0.2});
      const Vec3d eye = view.centre_in_world();
      Explanation seen;
      for (int y = 0; y < 72; ++y)
        for (int x = 0; x < 96; ++x) {
          const Vec3d ray = view.ray(x + 0.5, y + 0.5);
          bool ball = false;
          for (const Vec3d& centre : balls) {
            const Vec3d d = normalized(ray), to = centre - eye;
            ball = ball || length(to - dot(to, d) * d) < kPieceRadius;
          }
          const double z = (kFloorHeight - eye.z) / ray.z;
          seen.error.push_back(ball ? 2.f : 0.2f);
          seen.around.push_back(seen.error.back());
          seen.depth.push_back(z > 0 ? float(z) : 100.f);
        }
      views.push_back(view);
      explained.push_back(std::move(seen));
    }
  }
};

double farthest(const UnexplainedPiece& piece, const Vec3d& from) {
  double most = 0;
  for (const Vec3d& place : piece.places) most = std::max(most, length(place - from));
  return most;
}

TEST(UnexplainedPieces, AreWhereAllPhotosSeeThem) {
  const std::vector<Vec3d> balls{{0.45, 0, -0.25}, {-0.45, 0.1, -0.25}};
  const Scene scene(balls);
  const std::vector<UnexplainedPiece> pieces = unexplained_pieces(scene.views, scene.explained);
  ASSERT_EQ(pieces.size(), 2u);
  for (const UnexplainedPiece& piece : pieces) {
    const bool first = length(piece.places[0] - balls[0]) < length(piece.places[0] - balls[1]);
    const Vec3d& ball = balls[first ? 0 : 1];
    const auto inside =
        std::ranges::count_if(piece.places, [&](const Vec3d& p) { return length(p - ball) < 1.3 * kPieceRadius; });
    EXPECT_GT(farthest(piece, ball), 0.9 * kPieceRadius);
    EXPECT_GT(double(inside), 0.6 * double(piece.places.size()));  // cones of a ring meet above it, too
  }
}

TEST(UnexplainedPieces, ASurfaceInFrontIsNoContradiction) {
  const std::vector<Vec3d> ball{{0, 0, -0.25}};
  Scene scene(ball);
  for (size_t v = 0; v < kCameras; v += 3) {  // a box stands before it
    std::ranges::fill(scene.explained[v].around, 0.f);
    std::ranges::fill(scene.explained[v].depth, 0.3f);
  }
  const std::vector<UnexplainedPiece> pieces = unexplained_pieces(scene.views, scene.explained);
  ASSERT_FALSE(pieces.empty());
  EXPECT_GT(farthest(pieces.front(), ball[0]), 0.9 * kPieceRadius);
  for (size_t v = 0; v < kCameras; v += 3)  // those see past it
    std::ranges::fill(scene.explained[v].depth, 100.f);
  EXPECT_TRUE(unexplained_pieces(scene.views, scene.explained).empty());
}

TEST(UnexplainedPieces, NothingIsLeftWhereAllIsExplainedOrNothingIsKnown) {
  Scene scene({});
  EXPECT_TRUE(unexplained_pieces(scene.views, scene.explained).empty());
  for (Explanation& e : scene.explained) std::ranges::fill(e.around, -1.f);
  EXPECT_TRUE(unexplained_pieces(scene.views, scene.explained).empty());
}

}  // namespace
}  // namespace vitrine
