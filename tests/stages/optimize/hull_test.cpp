// Where surfels of glass are put.
#include "stages/optimize/hull.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/mesh/mesh_topology.h"
#include "core/scene/activation.h"
#include "core/train/picture_step.h"
#include "stages/optimize/glass_case.h"
#include "tests/core/stereo/outlines.h"

namespace vitrine {
namespace {

// Photos with masks, and nothing that the diffuse layer shows in front of them.
struct Marked {
  Capture capture;
  Targets targets;
  std::vector<std::vector<float>> depths;
  Marked(const std::vector<HullMask>& masks, MaskClass of) {
    for (const HullMask& m : masks) {
      capture.train.push_back(uint32_t(capture.photos.size()));
      capture.photos.emplace_back().levels[0].view = m.view;
      auto& inside = targets.photos.emplace_back()[0].masks[size_t(of)];
      for (float value : m.mask.data()) inside.push_back(value > 0 ? 255 : 0);
      depths.emplace_back(inside.size(), 0.f);
    }
  }
};

Hull hull_in(const std::vector<HullMask>& masks, HullClass kind, bool carried = false) {
  const MaskClass mask = kind == HullClass::Glass ? MaskClass::Transparent : MaskClass::Specular;
  Marked photos(masks, mask);
  photos.targets.carried[size_t(mask)] = carried;
  return mask_hull({.kind = kind, .capture = photos.capture, .targets = photos.targets, .depths = photos.depths, .cells = 48});
}

TEST(MaskHull, OfACaseIsItsSixFaces) {
  constexpr double kTurn = 0.35;
  const Vec3d half{0.2, 0.14, 0.28};
  const auto masks =
      outlines(24, 2 * std::numbers::pi, [&](const Vec3d& eye, const Vec3d& d) { return meets_box(half, kTurn, eye, d); });
  const Hull hull = hull_in(masks, HullClass::Glass);
  ASSERT_GT(hull.points.size(), 500u);
  const double c = std::cos(kTurn), s = std::sin(kTurn);
  for (const HullPoint& p : hull.points) {
    const Vec3d at{c * p.position.x + s * p.position.y, -s * p.position.x + c * p.position.y, double(p.position.z)};
    const Vec3d n{c * p.normal.x + s * p.normal.y, -s * p.normal.x + c * p.normal.y, double(p.normal.z)};
    size_t axis = 0;
    for (size_t i = 1; i < 3; ++i)
      if (std::abs(n[i]) > std::abs(n[axis])) axis = i;
    EXPECT_GT(std::abs(n[axis]), 0.9999);                                  // under a degree
    EXPECT_NEAR(at[axis], n[axis] > 0 ? half[axis] : -half[axis], 0.006);  // half a pixel
  }
}

// Photos look through the sides to a wall, and down to a floor that the case stands on; something stands in its middle.
TEST(GlassCase, StandsOnAFloorThatIsNoPane) {
  const Box box{Mat3d::identity(), {-0.2, -0.14, -0.28}, {0.2, 0.14, 0.28}};
  const auto masks =
      outlines(24, 2 * std::numbers::pi, [&](const Vec3d& eye, const Vec3d& d) { return box.crossing(eye, d).has_value(); });
  Marked photos(masks, MaskClass::Transparent);
  for (size_t photo = 0; photo < masks.size(); ++photo) {
    const View& view = masks[photo].view;
    const Vec3d eye = view.centre_in_world();
    const int width = view.intrinsics.width;
    for (size_t i = 0; i < photos.depths[photo].size(); ++i) {
      const Vec3d per_z =
          transposed_times(view.cam_from_world.rotation, view.intrinsics.ray(int(i) % width + 0.5, int(i) / width + 0.5));
      const auto c = box.crossing(eye, per_z);
      const double to_floor = (-0.29 - eye.z) / per_z.z;
      double z = c && c->left == Box::Face{2, false} ? to_floor : 4;
      if (c && i % 5 == 0) z = 0.5 * (c->in + c->out);
      photos.depths[photo][i] = i % 7 == 0 ? 0.f : float(z);
    }
  }
  const ShapeSet::Entry found = glass_case(box, photos.capture, photos.targets, photos.depths, 0);
  for (size_t f = 0; f < Box::kFaces; ++f) EXPECT_EQ(found.is_clear(f), f != (Box::Face{2, false}.index())) << f;
  EXPECT_EQ(found.role, ShapeRole::Sheet);
}

TEST(MaskHull, OfABallIsAsSmoothAsABall) {
  const Vec3d centre{0.05, -0.03, 0.02};
  const auto masks =
      outlines(24, 2 * std::numbers::pi, [&](const Vec3d& eye, const Vec3d& d) { return meets_ball(centre, 0.25, eye, d); });
  const Hull hull = hull_in(masks, HullClass::Gloss);
  ASSERT_GT(hull.points.size(), 500u);
  double angle = 0;
  for (const HullPoint& p : hull.points) {
    const Vec3d from = cast<double>(p.position) - centre;
    EXPECT_NEAR(length(from), 0.25, 0.02);
    EXPECT_TRUE(p.known);
    angle += std::acos(std::clamp(dot(normalized(from), cast<double>(p.normal)), -1.0, 1.0)) * 57.3 / double(hull.points.size());
  }
  EXPECT_LT(angle, 5);
}

// How far apart a ray and a rod between two points are.
double distance_to_rod(const Vec3d& eye, const Vec3d& direction, const Vec3d& from, const Vec3d& to) {
  double best = 1e9;
  for (int i = 0; i <= 100; ++i) {
    const Vec3d p = from + 0.01 * i * (to - from), q = p - eye;
    best = std::min(best, length(q - dot(q, direction) / dot(direction, direction) * direction));
  }
  return best;
}
double distance_to_rod(const Vec3d& p, const Vec3d& from, const Vec3d& to) {
  const double t = std::clamp(dot(p - from, to - from) / dot(to - from, to - from), 0.0, 1.0);
  return length(p - from - t * (to - from));
}

// A ball with a spout: the ball is a solid of revolution, the spout a mesh that stands out of it.
TEST(MaskHull, OfAKettleKnowsItsSpout) {
  constexpr double kBall = 0.25, kSpout = 0.035;
  const Vec3d from{0.2, 0, 0.05}, to{0.42, 0, 0.16};
  const auto masks = outlines(30, 2 * std::numbers::pi, [&](const Vec3d& eye, const Vec3d& d) {
    return meets_ball({0, 0, 0}, kBall, eye, d) || distance_to_rod(eye, d, from, to) < kSpout;
  });
  const Hull hull = hull_in(masks, HullClass::Gloss);
  ASSERT_EQ(hull.solids.size(), 1u);
  ASSERT_GT(hull.beside.faces.size(), 200u);
  const std::vector<Vec3f> normals = vertex_normals(hull.beside);
  double off = 0, angle = 0;
  size_t count = 0;
  for (size_t v = 0; v < normals.size(); ++v) {
    const Vec3d p = cast<double>(hull.beside.positions[v]);
    EXPECT_LT(std::min(distance_to_rod(p, from, to) - kSpout, std::abs(length(p) - kBall)), 0.02)
        << "nothing but the spout and its root";
    if (length(p) < kBall + kSpout || distance_to_rod(p, from, to) > 1.5 * kSpout) continue;
    const double t = std::clamp(dot(p - from, to - from) / dot(to - from, to - from), 0.0, 1.0);
    const Vec3d out = normalized(p - from - t * (to - from));
    off += std::abs(distance_to_rod(p, from, to) - kSpout);
    angle += std::acos(std::clamp(dot(out, cast<double>(normals[v])), -1.0, 1.0)) * 57.3;
    ++count;
  }
  ASSERT_GT(count, 200u);
  EXPECT_LT(off / double(count), 0.004);  // a third of a pixel
  EXPECT_LT(angle / double(count), 9);
  // Surfels stand closer together on the spout than on the ball.
  size_t on_ball = 0, on_spout = 0;
  for (const HullPoint& p : hull.points) {
    EXPECT_TRUE(p.known);
    (p.apart < 1 ? on_spout : on_ball) += 1;
  }
  const double ball = 4 * std::numbers::pi * kBall * kBall, spout = 2 * std::numbers::pi * kSpout * 0.25;
  EXPECT_GT(double(on_spout) / spout, 3 * double(on_ball) / ball);
}

// Masks that were carried from few marks have humps beside the root of a spout: those are the ball.
TEST(MaskHull, OfAKettleHasNoHumpsBesideItsSpout) {
  constexpr double kBall = 0.25;
  const Vec3d from{0.2, 0, 0.05}, to{0.42, 0, 0.16};
  const auto on_ball = [](double turn) { return 0.26 * Vec3d{std::cos(turn), std::sin(turn), 0}; };
  const auto masks = outlines(30, 2 * std::numbers::pi, [&](const Vec3d& eye, const Vec3d& d) {
    return meets_ball({0, 0, 0}, kBall, eye, d) || distance_to_rod(eye, d, from, to) < 0.035 ||
           distance_to_rod(eye, d, on_ball(0.15), on_ball(0.9)) < 0.02;
  });
  const Hull hull = hull_in(masks, HullClass::Gloss, true);
  ASSERT_EQ(hull.solids.size(), 1u);
  ASSERT_GT(hull.beside.faces.size(), 200u);
  for (const Vec3f& p : hull.beside.positions) EXPECT_GT(distance_to_rod(cast<double>(p), on_ball(0.6), on_ball(0.9)), 0.03);
  size_t on_hump = 0;
  for (const HullPoint& p : hull.points) {
    const Vec3d place = cast<double>(p.position);
    if (distance_to_rod(place, on_ball(0.65), on_ball(0.85)) > 0.03 || length(place) < kBall - 0.01) continue;
    EXPECT_LT(length(place), kBall + 0.008);
    ++on_hump;
  }
  EXPECT_GT(on_hump, 8u);
}

// A post in the same box as the ball and its spout, and not of them.
TEST(MaskHull, OfAKettleLeavesItsNeighbourAlone) {
  const Vec3d from{0.2, 0, 0.05}, to{0.42, 0, 0.16}, foot{0.38, -0.2, -0.15}, top{0.38, 0.1, -0.15};
  constexpr double kPost = 0.03;
  const auto masks = outlines(30, 2 * std::numbers::pi, [&](const Vec3d& eye, const Vec3d& d) {
    return meets_ball({0, 0, 0}, 0.25, eye, d) || distance_to_rod(eye, d, from, to) < 0.035 ||
           distance_to_rod(eye, d, foot, top) < kPost;
  });
  const Hull hull = hull_in(masks, HullClass::Gloss);
  ASSERT_EQ(hull.solids.size(), 1u);
  ASSERT_GT(hull.beside.faces.size(), 200u);
  for (const Vec3f& p : hull.beside.positions) EXPECT_GT(distance_to_rod(cast<double>(p), foot, top), 2 * kPost);
  size_t on_post = 0;
  for (const HullPoint& p : hull.points) {
    if (distance_to_rod(cast<double>(p.position), foot, top) > 2 * kPost) continue;
    EXPECT_FALSE(p.known) << "as a hull wavers";
    ++on_post;
  }
  EXPECT_GT(on_post, 50u);
}

TEST(MaskHull, WhatReflectsKeepsItsShapeAsFarAsItDoes) {
  SplatLayer layer(LayerKind::Diffuse, 0, 3);
  const float weights[] = {0.02f, 0.5f, 0.9f};
  for (size_t i = 0; i < 3; ++i) *layer.at(Attribute::SpecularWeight, i) = logit(weights[i]);
  std::vector<float> damping;
  const KnownSurface known({{0, 0, 0}, {0.05f, 0, 0}}, 0.1f);
  hold_gloss(layer, known, 0.02f, damping);
  for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(damping[i], 1 - 0.98f * weights[i], 1e-5);
  damping = {0.5f, 0.5f, 0.5f};  // of glass
  hold_gloss(layer, known, 0.02f, damping);
  EXPECT_NEAR(damping[2], 0.5f * (1 - 0.98f * 0.9f), 1e-5);
  damping.clear();
  layer.at(Attribute::Mean, 1)[0] = 0.2f;  // another thing that reflects, whose shape nobody knows
  layer.at(Attribute::Mean, 2)[0] = std::numeric_limits<float>::quiet_NaN();
  hold_gloss(layer, known, 0.02f, damping);
  EXPECT_NEAR(damping[0], 1 - 0.98f * weights[0], 1e-5);
  EXPECT_EQ(damping[1], 1) << "one known shape holds nothing but its own surfels";
  EXPECT_EQ(damping[2], 1);
}

TEST(Glass, ReflectsAlikeEverywhere) {
  SplatLayer layer(LayerKind::Diffuse, 0, 3);
  const float tau[] = {0.9f, 0.1f, 0.8f}, k_s[] = {1, 5, 2};
  for (size_t i = 0; i < 3; ++i) {
    *layer.at(Attribute::Transmission, i) = logit(tau[i]);
    *layer.at(Attribute::SpecularWeight, i) = k_s[i];
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::F0, i)[c] = k_s[i] + float(c);
  }
  share_glass(layer);
  for (const size_t glass : {0, 2}) {
    EXPECT_EQ(*layer.at(Attribute::SpecularWeight, glass), 1.5f);
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(layer.at(Attribute::F0, glass)[c], 1.5f + float(c));
  }
  EXPECT_EQ(*layer.at(Attribute::SpecularWeight, 1), 5);
  EXPECT_EQ(layer.at(Attribute::F0, 1)[2], 7);
  SplatLayer none(LayerKind::Diffuse, 0, 1);
  *none.at(Attribute::Transmission, 0) = -3;
  *none.at(Attribute::F0, 0) = 0.25f;
  share_glass(none);
  EXPECT_EQ(*none.at(Attribute::F0, 0), 0.25f);
}

TEST(MaskHull, OfNoMaskIsNone) {
  const Capture capture;
  const Targets targets;
  EXPECT_TRUE(mask_hull({.capture = capture, .targets = targets, .depths = {}}).points.empty());
}

}  // namespace
}  // namespace vitrine
