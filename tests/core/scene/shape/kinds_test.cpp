// Members that one kind alone has, and the kernel of derivatives against dual numbers; all else: registry_test.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/dual.h"
#include "core/scene/shape/box.h"
#include "core/scene/shape/kernels/revolution_point.h"
#include "core/scene/shape/surface_of_revolution.h"
#include "core/scene/shape/triangle_shape.h"

namespace vitrine {
namespace {

TEST(Box, RaysGoInAndOutByItsFaces) {
  const Quatd turn = normalized(Quatd{0.9, 0.1, -0.2, 0.3});
  const Box box{rotation_matrix(turn), {-1, -2, -3}, {1, 2, 3.5}};
  // From the far side of one face to that of another, through the middle.
  const Vec3d from = box.axes * Vec3d{-4, 0.5, 0.2}, to = box.axes * Vec3d{0.5, -0.4, 4.2};
  const auto c = box.crossing(from, to - from);
  ASSERT_TRUE(c);
  EXPECT_EQ(c->entered, (Box::Face{0, false}));
  EXPECT_EQ(c->left, (Box::Face{2, true}));
  for (const auto& [t, face] : {std::pair(c->in, c->entered), std::pair(c->out, c->left)}) {
    const Vec3d p = from + t * (to - from);
    EXPECT_NEAR(dot(box.normal(face), p), box.offset(face), 1e-12);
    EXPECT_NEAR(box.distance(p), 0, 1e-12);
    EXPECT_EQ(Box::face(face.index()), face);
  }
  EXPECT_FALSE(box.crossing(from, from - to)) << "behind";
  EXPECT_FALSE(box.crossing(box.axes * Vec3d{0, 0, 0}, to - from)) << "from inside";
  EXPECT_FALSE(box.crossing(from, box.axes * Vec3d{0, 1, 0}));
  EXPECT_NEAR(box.distance(box.axes * Vec3d{0.8, 0, 0}), -0.2, 1e-12);
  EXPECT_NEAR(box.distance(box.axes * Vec3d{4, 6, 0}), 5, 1e-12);
  EXPECT_EQ(box.longest_side(), 6.5);
}

using SegmentDual = Dual<double, 14>;

// A vase with a level lid: every kind of segment.
SurfaceOfRevolution vase() {
  SurfaceOfRevolution s{{0.1, -0.2, 0.05}, normalized(Vec3d{0.05, -0.1, 1}), {{0, 0}, {0.2, 0}}};
  for (int i = 1; i <= 20; ++i) s.profile.push_back({0.2 + 0.1 * std::sin(0.3 * i), 0.03 * i});
  s.profile.push_back({0.1, 0.6});
  s.profile.push_back({0, 0.62});
  return s;
}

ProfileSegment<double> segment_of(const SurfaceOfRevolution& s, size_t i) {
  return {s.origin, s.axis, s.profile[i], s.profile[i + 1], s.vertex_normal(i), s.vertex_normal(i + 1)};
}

Ray ray_at(const SurfaceOfRevolution& s, Rng& rng) {
  const auto unit = [&] { return 2 * rng.uniform_double() - 1; };
  const Vec3d eye{2 * unit(), 2 * unit(), 0.4 + unit()};
  const Vec3d at = s.origin + 0.3 * s.axis + Vec3d{0.25 * unit(), 0.25 * unit(), 0.35 * unit()};
  return {eye, at - eye};
}

TEST(RevolutionPoint, MatchesDualNumbers) {
  const SurfaceOfRevolution s = vase();
  Rng rng(2, 1);
  size_t seen = 0;
  for (int k = 0; k < 200; ++k) {
    const Ray ray = ray_at(s, rng);
    const auto entry = s.intersect(ray);
    if (!entry) continue;
    const ProfileSegment<double> segment = segment_of(s, entry->element);
    const RevolutionPoint<double> point = revolution_point(segment, ray.origin, ray.direction, entry->t);
    if (std::abs(dot(normalized(ray.direction), point.normal)) < 0.05) continue;
    ++seen;
    EXPECT_NEAR(point.t, entry->t, 1e-9);
    EXPECT_NEAR(length(point.normal - entry->normal), 0, 1e-9);
    size_t v = 0;
    const auto number = [&](double x) { return SegmentDual::variable(x, v++); };
    ProfileSegment<SegmentDual> d;
    for (size_t c = 0; c < 3; ++c) d.origin[c] = number(segment.origin[c]);
    for (size_t c = 0; c < 3; ++c) d.axis[c] = number(segment.axis[c]);
    for (auto [to, from] :
         {std::pair{&d.p0, segment.p0}, std::pair{&d.p1, segment.p1}, std::pair{&d.n0, segment.n0}, std::pair{&d.n1, segment.n1}})
      for (size_t c = 0; c < 2; ++c) (*to)[c] = number(from[c]);
    const auto constant = [](const Vec3d& x) { return Vec3<SegmentDual>{SegmentDual(x.x), SegmentDual(x.y), SegmentDual(x.z)}; };
    const RevolutionPoint<SegmentDual> exact =
        revolution_point(d, constant(ray.origin), constant(ray.direction), SegmentDual(entry->t));
    const RevolutionPoint<double> g{rng.uniform_double(), {rng.uniform_double(), rng.uniform_double(), rng.uniform_double()}};
    const SegmentDual value = g.t * exact.t + dot(constant(g.normal), exact.normal);
    const ProfileSegment<double> back = revolution_point_vjp(segment, ray.origin, ray.direction, point.t, g);
    std::vector<double> flat;
    for (const Vec3d* x : {&back.origin, &back.axis})
      for (size_t c = 0; c < 3; ++c) flat.push_back((*x)[c]);
    for (const Vec2d* x : {&back.p0, &back.p1, &back.n0, &back.n1})
      for (size_t c = 0; c < 2; ++c) flat.push_back((*x)[c]);
    for (size_t i = 0; i < flat.size(); ++i)
      EXPECT_NEAR(flat[i], value.d[i], 1e-6 * (1 + std::abs(value.d[i]))) << "ray " << k << ", number " << i;
  }
  EXPECT_GT(seen, 50u);
}

TEST(SurfaceOfRevolution, EqualSegmentsKeepTheCurve) {
  const SurfaceOfRevolution s = vase(), fine = with_equal_segments(s, 200);
  ASSERT_EQ(fine.profile.size(), 201u);
  const auto length_of = [&](size_t i) {
    return std::hypot(fine.profile[i + 1].x - fine.profile[i].x, fine.profile[i + 1].y - fine.profile[i].y);
  };
  for (const Vec2d& p : fine.profile) {
    const Vec3d at = s.origin + p.y * s.axis + p.x * normalized(cross(s.axis, Vec3d{0, 1, 0}));
    EXPECT_NEAR(length(s.nearest(at).position - at), 0, 1e-12);
  }
  for (size_t i = 0; i < 200; ++i) EXPECT_LE(length_of(i), 1.0001 * length_of(100));
}

// It said so after reading past the end of the vertices.
TEST(TriangleShape, RefusesFacesOfVerticesThatDoNotExist) {
  TriMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 70000000}};
  try {
    TriangleShape shape(mesh);
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.detail().code, "BAD_MESH");
    EXPECT_EQ(e.detail().why, "vertex 70000000 of 3");
  }
}

}  // namespace
}  // namespace vitrine
