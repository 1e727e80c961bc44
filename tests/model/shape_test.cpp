// Polished pixels whose surface a turned solid tells: the kernel against dual numbers, its hits against the solid's equation,
// what a picture asks of axis and profile against differences.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rng.h"
#include "core/math/dual.h"
#include "core/math/turned_surface.h"
#include "core/mesh/mesh_topology.h"
#include "core/model/gbuffer.h"
#include "core/model/kernels/turned_point.h"
#include "core/model/shape_mesh.h"
#include "core/train/shape_training.h"
#include "tests/model/exact_model.h"
#include "tests/model/tiny_rooms.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

using LineDual = Dual<double, 14>;

// A vase with a level lid: every kind of line.
TurnedSurface vase() {
  TurnedSurface s{{0.1, -0.2, 0.05}, normalized(Vec3d{0.05, -0.1, 1}), {{0, 0}, {0.2, 0}}};
  for (int i = 1; i <= 20; ++i) s.profile.push_back({0.2 + 0.1 * std::sin(0.3 * i), 0.03 * i});
  s.profile.push_back({0.1, 0.6});
  s.profile.push_back({0, 0.62});
  return s;
}

TurnedLine<double> line_of(const TurnedSurface& s, size_t i) {
  const auto n = s.corner_normals();
  return {s.origin, s.axis, s.profile[i], s.profile[i + 1], n[i], n[i + 1]};
}

struct Ray {
  Vec3d eye, direction;
};
Ray ray_at(const TurnedSurface& s, Rng& rng) {
  const auto unit = [&] { return 2 * rng.uniform_double() - 1; };
  const Vec3d eye{2 * unit(), 2 * unit(), 0.4 + unit()};
  const Vec3d at = s.origin + 0.3 * s.axis + Vec3d{0.25 * unit(), 0.25 * unit(), 0.35 * unit()};
  return {eye, at - eye};
}

TEST(TurnedSurface, RaysGoInWhereTheyFirstMeetIt) {
  const TurnedSurface s = vase();
  Rng rng(1, 1);
  size_t hits = 0;
  // The radius of the solid at a height: none outside of its ends.
  const auto inside = [&](const Vec3d& p) {
    const Vec3d q = p - s.origin;
    const double h = dot(q, s.axis), r = length(q - h * s.axis);
    for (size_t i = 0; i + 1 < s.profile.size(); ++i) {
      const Vec2d &a = s.profile[i], &b = s.profile[i + 1];
      if (h < a.y || h >= b.y) continue;
      return r < a.x + (b.x - a.x) * (h - a.y) / (b.y - a.y);
    }
    return false;
  };
  for (int k = 0; k < 300; ++k) {
    const Ray ray = ray_at(s, rng);
    if (inside(ray.eye)) continue;
    double marched = -1;
    constexpr double kStep = 2e-4;
    for (double t = 0; t < 2 && marched < 0; t += kStep)
      if (inside(ray.eye + t * ray.direction)) marched = t;
    const auto entry = s.entry(ray.eye, ray.direction);
    if (marched < 0) continue;  // it may pass by closer than a step
    ++hits;
    ASSERT_TRUE(entry);
    EXPECT_NEAR(entry->t, marched, 1.01 * kStep) << k;
  }
  EXPECT_GT(hits, 100u);
}

TEST(TurnedPoint, MatchesDualNumbers) {
  const TurnedSurface s = vase();
  Rng rng(2, 1);
  size_t seen = 0;
  for (int k = 0; k < 200; ++k) {
    const Ray ray = ray_at(s, rng);
    const auto entry = s.entry(ray.eye, ray.direction);
    if (!entry) continue;
    const TurnedLine<double> line = line_of(s, entry->line);
    const TurnedPoint<double> point = turned_point(line, ray.eye, ray.direction, entry->t);
    if (std::abs(dot(normalized(ray.direction), point.normal)) < 0.05) continue;
    ++seen;
    EXPECT_NEAR(point.t, entry->t, 1e-9);
    size_t v = 0;
    const auto number = [&](double x) { return LineDual::variable(x, v++); };
    TurnedLine<LineDual> d;
    for (size_t c = 0; c < 3; ++c) d.origin[c] = number(line.origin[c]);
    for (size_t c = 0; c < 3; ++c) d.axis[c] = number(line.axis[c]);
    for (auto [to, from] :
         {std::pair{&d.p0, line.p0}, std::pair{&d.p1, line.p1}, std::pair{&d.n0, line.n0}, std::pair{&d.n1, line.n1}})
      for (size_t c = 0; c < 2; ++c) (*to)[c] = number(from[c]);
    const auto constant = [](const Vec3d& x) { return Vec3<LineDual>{LineDual(x.x), LineDual(x.y), LineDual(x.z)}; };
    const TurnedPoint<LineDual> exact = turned_point(d, constant(ray.eye), constant(ray.direction), LineDual(entry->t));
    const TurnedPoint<double> g{rng.uniform_double(), {rng.uniform_double(), rng.uniform_double(), rng.uniform_double()}};
    const LineDual value = g.t * exact.t + dot(constant(g.normal), exact.normal);
    const TurnedLine<double> back = turned_point_vjp(line, ray.eye, ray.direction, point.t, g);
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

TEST(TurnedSurface, TheNearestPointIsTheFootOfThePerpendicular) {
  const TurnedSurface s = vase();
  Rng rng(5, 1);
  for (int k = 0; k < 50; ++k) {
    const Vec3d p = ray_at(s, rng).eye;
    const TurnedSurface::Place near = s.nearest(p);
    for (double turn = 0; turn < 6.2; turn += 0.1)
      for (size_t i = 0; i + 1 < s.profile.size(); ++i) {
        const Vec3d u = normalized(cross(s.axis, Vec3d{1, 0.2, 0})), v = cross(s.axis, u);
        const Vec2d q{0.5 * (s.profile[i].x + s.profile[i + 1].x), 0.5 * (s.profile[i].y + s.profile[i + 1].y)};
        const Vec3d other = s.origin + q.y * s.axis + q.x * (std::cos(turn) * u + std::sin(turn) * v);
        ASSERT_LE(length(near.position - p), length(other - p) + 1e-12);
      }
    EXPECT_NEAR(length(near.normal), 1, 1e-12);
  }
}

TEST(TurnedSurface, EqualLinesKeepTheCurve) {
  const TurnedSurface s = vase(), fine = with_equal_lines(s, 200);
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

TEST(TurnedSurface, NormalsOfCornersMatchDifferences) {
  const TurnedSurface s = vase();
  Rng rng(3, 1);
  std::vector<Vec2d> g(s.profile.size()), back(s.profile.size());
  for (Vec2d& v : g) v = {rng.uniform_double(), rng.uniform_double()};
  corner_normals_vjp(s, g, back);
  const auto value = [&](const TurnedSurface& at) {
    double sum = 0;
    const auto n = at.corner_normals();
    for (size_t i = 0; i < n.size(); ++i) sum += g[i].x * n[i].x + g[i].y * n[i].y;
    return sum;
  };
  constexpr double kStep = 1e-6;
  for (size_t i = 0; i < s.profile.size(); ++i)
    for (size_t c = 0; c < 2; ++c) {
      TurnedSurface a = s, b = s;
      a.profile[i][c] -= kStep, b.profile[i][c] += kStep;
      EXPECT_NEAR(back[i][c], (value(b) - value(a)) / (2 * kStep), 1e-6) << i;
    }
}

// A ball about an axis.
TurnedSurface ball(const Vec3d& centre, double radius, const Vec3d& axis, size_t lines = 40) {
  TurnedSurface s{centre, normalized(axis), {}};
  for (size_t i = 0; i <= lines; ++i) {
    const double a = 3.14159265358979 * (double(i) / double(lines) - 0.5);
    s.profile.push_back({i == 0 || i == lines ? 0 : radius * std::cos(a), radius * std::sin(a)});
  }
  return s;
}

// A sheet that mirrors, and a ball that touches it from behind: large enough to be everywhere near.
struct BallRoom {
  LayeredRoom room = furnished_room({.specular = 0.7, .transmission = 0.01}, 5, 13, 11);
  std::shared_ptr<std::vector<TurnedSurface>> shapes = std::make_shared<std::vector<TurnedSurface>>();
  ImageOptions options = exact_options();
  Vec3d centre = room.point - 4. * room.normal;
  BallRoom() {
    shapes->push_back(ball(centre, 4, {0.3, 1, 0.2}));
    options.shape.shapes = shapes;
  }
  double loss(const LayeredModel& model, Frame& frame) const {
    model.forward(room.scene, room.view, frame);
    double sum = 0;
    for (float v : frame.srgb) sum += 0.5 * std::pow(double(v) - 0.3, 2);
    return sum;
  }
};

TEST(ShapePass, PolishedPixelsHaveThePlaceAndTheNormalOfTheSolid) {
  BallRoom r;
  LayeredModel model(r.options);
  Frame frame;
  model.forward(r.room.scene, r.room.view, frame);
  ASSERT_EQ(frame.shaded.groups(), frame.pixel_count());
  for (size_t g = 0; g < frame.shaded.groups(); ++g) {
    const SurfacePoint<float>& p = frame.shaded.points[g];
    const Vec3d out = cast<double>(p.position) - r.centre;
    EXPECT_NEAR(length(out), 4, 0.02) << "chords";
    EXPECT_GT(dot(normalized(out), cast<double>(p.normal)), 0.9999);
    EXPECT_EQ(p.agreement, 1);
  }
  // What is not polished, what stands in front, and what is far behind keep their own.
  const auto own = [&] {
    Frame with, without;
    model.forward(r.room.scene, r.room.view, with);
    ImageOptions none = r.options;
    none.shape.shapes = nullptr;
    LayeredModel(none).forward(r.room.scene, r.room.view, without);
    return std::ranges::equal(with.diffuse.plane(Aov::Normal), without.diffuse.plane(Aov::Normal)) && with.srgb == without.srgb;
  };
  EXPECT_FALSE(own());
  model.shape->options().polished = 0.95f;
  EXPECT_TRUE(own());
  model.shape->options() = r.options.shape;
  for (const double away : {-1.0, 3.0}) {
    (*r.shapes)[0].origin = r.centre + away * r.room.normal;
    EXPECT_TRUE(own()) << away;
  }
}

// Surfels that do not close let the far side of the solid through, which cannot be seen.
TEST(ShapePass, GapsOfTheNearSideShowTheSolid) {
  BallRoom r;
  (*r.shapes)[0] = ball(r.room.point + 0.3 * r.room.normal, 0.5, {0.3, 1, 0.2});  // the sheet is its far half
  LayeredModel model(r.options);
  Frame frame;
  model.forward(r.room.scene, r.room.view, frame);
  const auto width = static_cast<uint32_t>(r.room.view.intrinsics.width),
             height = static_cast<uint32_t>(r.room.view.intrinsics.height);
  const uint32_t middle = (height / 2) * width + width / 2;
  EXPECT_EQ(frame.outline.shapes[middle], 1u);
  const GBuffer g(frame);
  const PixelRay<float> ray = g.ray(middle);
  const Vec3d place = cast<double>(ray.eye + (g.zdepth[middle] / g.alpha[middle]) * ray.direction_per_z);
  EXPECT_NEAR(length(place - (*r.shapes)[0].origin), 0.5, 0.01);
}

// A spout in front of a ball, as a mesh; both learn.
TEST(ShapePass, AMeshTellsWhatStandsOutOfTheSolid) {
  BallRoom r;
  TriMesh patch;  // before the sheet by less than its tolerance, turned by 39 degrees, over a half of the picture
  const Vec3d x = normalized(cross(r.room.normal, Vec3d{0, 1, 0})), y = cross(r.room.normal, x);
  const Vec3d n = normalized(r.room.normal - 0.8 * x), along = cross(y, n);
  for (const auto& [u, v] : {std::pair{0., -2.}, {0.3, -2.}, {0.3, 2.}, {0., 2.}})
    patch.positions.push_back(cast<float>(r.room.point + 0.1 * r.room.normal + u * along + v * y));
  patch.faces = {{0, 1, 2}, {0, 2, 3}};
  const auto facing = [](TriMesh m, const Vec3d& towards) {
    if (dot(cast<double>(vertex_normals(m)[0]), towards) < 0)
      for (auto& f : m.faces) std::swap(f[1], f[2]);
    return m;
  };
  r.options.shape.beside = std::make_shared<ShapeMesh>(facing(patch, n), 0.3f);
  LayeredModel model(r.options);
  Frame frame;
  r.loss(model, frame);
  const GBuffer g(frame);
  size_t of_mesh = 0, of_ball = 0;
  for (uint32_t i = 0; i < g.pixels; ++i) {
    const Vec3d normal = cast<double>(normalized(g.rgb(g.normal, i)));
    if (frame.outline.shapes[i] == 1) {
      ++of_ball;
      continue;
    }
    ++of_mesh;
    EXPECT_NEAR(dot(normal, n), 1, 1e-4);
    const PixelRay<float> ray = g.ray(i);
    const Vec3d place = cast<double>(ray.eye + (g.zdepth[i] / g.alpha[i]) * ray.direction_per_z);
    EXPECT_NEAR(dot(place - (r.room.point + 0.1 * r.room.normal), n), 0, 1e-4);
  }
  EXPECT_GT(of_mesh, 10u);
  EXPECT_GT(of_ball, 10u);
  start_gradient(frame);
  SplatScene grad = r.room.scene.zeros_like();
  model.backward(r.room.scene, frame, grad);
  EXPECT_GT(length(model.shape->gradients().at(0).origin), 0);
  ASSERT_EQ(model.shape->beside_gradient().size(), 4u);
  for (double v : model.shape->beside_gradient()) EXPECT_NE(v, 0);
  // Its back is not seen, and a mesh far in front is another thing.
  const auto picture = [&](TriMesh mesh) {
    ImageOptions options = r.options;
    options.shape.beside = std::make_shared<ShapeMesh>(std::move(mesh), 0.3f);
    Frame f;
    LayeredModel(options).forward(r.room.scene, r.room.view, f);
    return f.srgb;
  };
  ImageOptions none = r.options;
  none.shape.beside = nullptr;
  Frame without;
  LayeredModel(none).forward(r.room.scene, r.room.view, without);
  EXPECT_NE(frame.srgb, without.srgb);
  EXPECT_EQ(picture(facing(patch, -n)), without.srgb);
  TriMesh behind = facing(patch, n);
  for (Vec3f& p : behind.positions) p -= cast<float>(1.0 * r.room.normal);
  EXPECT_EQ(picture(behind), without.srgb);
}

// The ball's numbers and, with the ball there, those of the layers.
TEST(ShapePass, GradientsMatchDifferences) {
  BallRoom r;
  LayeredModel model(r.options);
  Frame frame;
  r.loss(model, frame);
  start_gradient(frame);
  SplatScene grad = r.room.scene.zeros_like();
  model.backward(r.room.scene, frame, grad);
  ASSERT_EQ(model.shape->gradients().size(), 1u);
  const TurnedGradient g = model.shape->gradients()[0];
  std::vector<float> exact;
  std::vector<double> differences;
  const auto number = [&](double gradient, double& value) {
    constexpr double kStep = 2e-3;
    const double was = value;
    value = was + kStep;
    const double above = r.loss(model, frame);
    value = was - kStep;
    const double below = r.loss(model, frame);
    value = was;
    exact.push_back(static_cast<float>(gradient)), differences.push_back((above - below) / (2 * kStep));
  };
  TurnedSurface& s = (*r.shapes)[0];
  for (size_t c = 0; c < 3; ++c) number(g.origin[c], s.origin[c]);
  for (size_t c = 0; c < 3; ++c) number(g.axis[c], s.axis[c]);
  expect_grad_close(exact, differences, {.relative_l2 = 2e-2, .bias = 2e-2, .row_floor = 0.05}, "axis");
  exact.clear(), differences.clear();
  for (size_t i = 0; i < s.profile.size(); ++i)
    for (size_t c = 0; c < 2; ++c) number(g.profile[i][c], s.profile[i][c]);
  expect_grad_close(exact, differences, {.relative_l2 = 5e-2, .bias = 5e-2, .row_floor = 0.1}, "profile");

  const auto loss = [&] { return r.loss(model, frame); };
  for (LayerKind kind : {LayerKind::Diffuse, LayerKind::Reflection})
    for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::Opacity, Attribute::F0, Attribute::SpecularWeight}) {
      auto values = r.room.scene.layer(kind).values(a);
      if (values.empty()) continue;
      const std::vector<double> by_difference = extrapolated_differences(values, loss);
      const auto actual = grad.layer(kind).values(a);
      expect_grad_close(std::vector<float>(actual.begin(), actual.end()), by_difference,
                        {.relative_l2 = 2e-2, .bias = 2e-2, .row_floor = 0.05},
                        std::string(name(kind)) + " " + std::string(row(a).name));
    }
}

// A ball that is off finds back to what the photo of the true one mirrors.
TEST(ShapeTraining, FindsTheSolidThatWasPhotographed) {
  BallRoom r;
  LayeredModel model(r.options);
  Frame frame;
  model.forward(r.room.scene, r.room.view, frame);
  const std::vector<float> photo = frame.srgb;
  const auto error = [&] {
    double sum = 0;
    for (size_t i = 0; i < photo.size(); ++i) sum += std::pow(double(frame.srgb[i]) - double(photo[i]), 2);
    return sum;
  };
  ShapeTraining training({ball(r.centre + Vec3d{0.05, -0.04, 0.03}, 4.03, {0.3, 1, 0.2})}), resumed;
  SplatScene ignored = r.room.scene.zeros_like();
  double first = 0;
  for (int step = 0; step < 150; ++step) {
    *r.shapes = training.shapes();
    model.forward(r.room.scene, r.room.view, frame);
    if (step == 0) first = error();
    for (size_t i = 0; i < photo.size(); ++i) frame.grad_srgb[i] = frame.srgb[i] - photo[i];
    model.backward(r.room.scene, frame, ignored);
    training.descend(model.shape->gradients(), {.origin = 2e-3, .axis = 1e-4, .profile = 1e-3});
    if (step != 75) continue;
    ArchiveWriter out;
    training.save(out);
    ArchiveReader in(out.bytes());
    resumed.load(in);
    EXPECT_TRUE(in.at_end());
    resumed.descend(model.shape->gradients(), {.origin = 2e-3, .axis = 1e-4, .profile = 1e-3});
    ShapeTraining once = training;
    once.descend(model.shape->gradients(), {.origin = 2e-3, .axis = 1e-4, .profile = 1e-3});
    EXPECT_EQ(resumed.shapes()[0].origin, once.shapes()[0].origin) << "a killed run goes on alike";
  }
  EXPECT_GT(first, 1e-3);
  EXPECT_LT(error(), 0.05 * first);
  // Broken gradients move nothing.
  auto broken = model.shape->gradients();
  broken[0].profile[3].x = NAN;
  const Vec3d before = training.shapes()[0].origin;
  training.descend(broken, {.origin = 1, .axis = 1, .profile = 1});
  EXPECT_EQ(training.shapes()[0].origin, before);
}

}  // namespace
}  // namespace vitrine
