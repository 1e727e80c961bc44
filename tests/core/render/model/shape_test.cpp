// Specular pixels whose surface a known shape gives; what a picture asks of its parameters against differences, and training.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/render/model/gbuffer.h"
#include "core/scene/shape/shape.h"
#include "core/learn/trainer/shape_training.h"
#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/tiny_rooms.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

// A ball about an axis.
SurfaceOfRevolution ball(const Vec3d& centre, double radius, const Vec3d& axis, size_t lines = 40) {
  SurfaceOfRevolution s{centre, normalized(axis), {}};
  for (size_t i = 0; i <= lines; ++i) {
    const double a = 3.14159265358979 * (double(i) / double(lines) - 0.5);
    s.profile.push_back({i == 0 || i == lines ? 0 : radius * std::cos(a), radius * std::sin(a)});
  }
  return s;
}

// A sheet that mirrors, and a ball that touches it from behind: large enough to be everywhere near.
struct BallRoom {
  LayeredRoom room = furnished_room({.specular = 0.7, .transmission = 0.01}, 5, 13, 11);
  std::shared_ptr<ShapeSet> set = std::make_shared<ShapeSet>();
  ImageOptions options = exact_options();
  Vec3d centre = room.point - 4. * room.normal;
  BallRoom() {
    add(ball(centre, 4, {0.3, 1, 0.2}), 0.24);
    options.shape.set = set;
  }
  void add(Shape shape, double tolerance, int parent = -1) {
    set->entries.push_back({std::move(shape), ShapeRole::Mirror, tolerance, parent, {}});
  }
  SurfaceOfRevolution& first() { return std::get<SurfaceOfRevolution>(set->entries[0].shape); }
  double loss(const LayeredModel& model, Frame& frame) const {
    model.forward(room.scene, room.view, frame);
    return loss_of(frame);
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
    none.shape.set = nullptr;
    LayeredModel(none).forward(r.room.scene, r.room.view, without);
    return std::ranges::equal(with.diffuse.plane(Aov::Normal), without.diffuse.plane(Aov::Normal)) && with.srgb == without.srgb;
  };
  EXPECT_FALSE(own());
  model.options().shape.min_specular = 0.95f;
  EXPECT_TRUE(own());
  model.options().shape = r.options.shape;
  for (const double away : {-1.0, 3.0}) {
    r.first().origin = r.centre + away * r.room.normal;
    EXPECT_TRUE(own()) << away;
  }
}

// Paint keeps its channels and its surfels where they are; the shape turns the reflection.
TEST(ShapePass, ACoatMirrorsWithTheShapeAndKeepsThePaint) {
  BallRoom r;
  r.set->entries[0].role = ShapeRole::Coat;
  SplatLayer& paint = r.room.scene.diffuse;
  for (size_t i = 0; i < paint.size(); ++i)
    *paint.at(Attribute::SpecularWeight, i) = *paint.at(Attribute::Transmission, i) = logit(1e-4f);
  LayeredModel model(r.options);
  Frame frame, without;
  ImageOptions none = r.options;
  none.shape.set = nullptr;
  LayeredModel(none).forward(r.room.scene, r.room.view, without);
  EXPECT_EQ(without.shaded.groups(), 0u) << "so little k_s sends no rays";
  const auto run = [&](bool exact) {
    r.set->entries[0].exact = exact;
    model.forward(r.room.scene, r.room.view, frame);
    EXPECT_EQ(frame.shaded.groups(), frame.pixel_count());
    for (Aov a : {Aov::Normal, Aov::ZDepth, Aov::Color})
      EXPECT_TRUE(std::ranges::equal(frame.diffuse.plane(a), without.diffuse.plane(a)));
    EXPECT_NE(frame.srgb, without.srgb) << "Fresnel acts";
    frame.grad_srgb.assign(frame.srgb.size(), 1.f);
    SplatScene grad = r.room.scene.zeros_like();
    model.backward(r.room.scene, frame, grad);
    for (const float g : grad.diffuse.values(Attribute::F0)) EXPECT_EQ(g, 0) << "f0 is that of the clear layer";
    EXPECT_TRUE(std::ranges::any_of(grad.diffuse.values(Attribute::SpecularWeight), [](float g) { return g != 0; }));
    EXPECT_TRUE(std::ranges::any_of(grad.reflection.values(Attribute::ShDc), [](float g) { return g != 0; }));
  };
  run(true);
  for (const SurfacePoint<float>& p : frame.shaded.points) {
    const Vec3d out = cast<double>(p.position) - r.centre;
    EXPECT_NEAR(length(out), 4, 0.02) << "chords";
    EXPECT_GT(dot(normalized(out), cast<double>(p.normal)), 0.9999);
  }
  run(false);
  const GBuffer g(frame);
  for (size_t i = 0; i < frame.shaded.groups(); ++i) {
    const Vec3f own = normalized(g.rgb(g.normal, frame.shaded.chosen_pixel(i)));
    EXPECT_GT(dot(own, frame.shaded.points[i].normal), 0.9999f) << "a hull does not turn it";
  }
}

// Surfels that do not close let the far side of the solid through, which cannot be seen.
TEST(ShapePass, GapsOfTheNearSideShowTheSolid) {
  BallRoom r;
  r.set->entries[0] = {ball(r.room.point + 0.3 * r.room.normal, 0.5, {0.3, 1, 0.2}), ShapeRole::Mirror, 0.03, -1, {}};
  LayeredModel model(r.options);
  Frame frame;
  model.forward(r.room.scene, r.room.view, frame);
  const auto width = static_cast<uint32_t>(r.room.view.intrinsics.width),
             height = static_cast<uint32_t>(r.room.view.intrinsics.height);
  const uint32_t middle = (height / 2) * width + width / 2;
  EXPECT_EQ(frame.silhouette.shapes[middle], 1u);
  const GBuffer g(frame);
  const PixelRay<float> ray = g.ray(middle);
  const Vec3d place = cast<double>(ray.eye + (g.zdepth[middle] / g.alpha[middle]) * ray.direction_per_z);
  EXPECT_NEAR(length(place - r.first().origin), 0.5, 0.01) << "and not its far half, which the sheet is";
}

// The first one of the list was shown, and the nearest one had the silhouettes.
TEST(ShapePass, ShowsTheNearestOfShapesThatOverlap) {
  BallRoom r;
  r.add(ball(r.centre + 0.05 * r.room.normal, 4, {0.3, 1, 0.2}), 0.24);
  r.add(ball(r.centre + 1.5 * r.room.normal, 4, {0.3, 1, 0.2}), 0.01);  // nearer, and not in the picture
  LayeredModel model(r.options);
  Frame frame;
  model.forward(r.room.scene, r.room.view, frame);
  const Vec3d eye = r.room.view.centre_in_world();
  ShapeSet in_picture = *r.set;
  in_picture.entries.pop_back();
  size_t second = 0;
  const GBuffer g(frame);
  for (uint32_t i = 0; i < g.pixels; ++i) {
    const auto hit = in_picture.first_hit({eye, cast<double>(g.ray(i).direction_per_z)}, ShapeRole::Mirror);
    ASSERT_TRUE(hit);
    EXPECT_EQ(frame.silhouette.shapes[i], hit->entry + 1);
    second += hit->entry == 1;
  }
  EXPECT_GT(second, g.pixels / 2);
}

// A mesh in front of a ball, with the ball as its parent; both learn.
TEST(ShapePass, AnAppendageHidesItsParent) {
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
  r.add(TriangleShape(facing(patch, n)), 0.3, 0);
  LayeredModel model(r.options);
  Frame frame;
  r.loss(model, frame);
  const GBuffer g(frame);
  size_t of_mesh = 0, of_ball = 0;
  for (uint32_t i = 0; i < g.pixels; ++i) {
    const Vec3d normal = cast<double>(normalized(g.rgb(g.normal, i)));
    if (frame.silhouette.shapes[i] == 1) {
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
  EXPECT_NE(model.shape().gradients().at(0).at(0), 0);
  ASSERT_EQ(model.shape().gradients().at(1).size(), 4u);
  for (double v : model.shape().gradients()[1]) EXPECT_NE(v, 0);
  // Its back is not seen, and a mesh far in front is another thing.
  const auto picture = [&](TriMesh mesh) {
    r.set->entries[1].shape = TriangleShape(std::move(mesh));
    Frame f;
    LayeredModel(r.options).forward(r.room.scene, r.room.view, f);
    return f.srgb;
  };
  ImageOptions ball_alone = r.options;
  ball_alone.shape.set = std::make_shared<const ShapeSet>(r.set->kept(std::vector<uint8_t>{1, 0}));
  Frame without;
  LayeredModel(ball_alone).forward(r.room.scene, r.room.view, without);
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
  ASSERT_EQ(model.shape().gradients().size(), 1u);
  const std::vector<double> g = model.shape().gradients()[0];
  const SurfaceOfRevolution at = r.first();
  std::vector<float> exact;
  std::vector<double> differences, step(g.size(), 0.0);
  const auto number = [&](size_t i) {
    constexpr double kStep = 2e-3;
    double loss[2];
    for (const size_t side : {0, 1}) {
      step[i] = side == 0 ? -kStep : kStep;
      r.first() = at.moved(step);
      loss[side] = r.loss(model, frame);
    }
    step[i] = 0;
    r.first() = at;
    exact.push_back(static_cast<float>(g[i])), differences.push_back((loss[1] - loss[0]) / (2 * kStep));
  };
  for (size_t i = 0; i < 4; ++i) number(i);
  expect_grad_close(exact, differences, {.relative_l2 = 2e-2, .bias = 2e-2, .row_floor = 0.05}, "axis");
  exact.clear(), differences.clear();
  for (size_t i = 4; i < g.size(); ++i) number(i);
  expect_grad_close(exact, differences, {.relative_l2 = 5e-2, .bias = 5e-2, .row_floor = 0.1}, "profile");

  const auto loss = [&] { return r.loss(model, frame); };
  for (LayerKind kind : {LayerKind::Diffuse, LayerKind::Reflection})
    for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::Opacity, Attribute::F0, Attribute::SpecularWeight})
      if (!r.room.scene.layer(kind).values(a).empty()) expect_differences(r.room.scene, grad, kind, a, loss);
}

ShapeTraining saved_and_loaded(ShapeTraining training) {
  Archive out;
  training.transfer(out);
  Archive in(out.bytes());
  ShapeTraining loaded;
  loaded.transfer(in);
  EXPECT_TRUE(in.at_end());
  return loaded;
}

// A bumpy sheet of triangles; seen from +z.
Shape sheet(int side, double bump) {
  TriMesh m;
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) {
      const double x = double(i) / side - 0.5, y = double(j) / side - 0.5;
      m.positions.push_back(cast<float>(Vec3d{x + 0.1 * y, y, bump * std::sin(5 * x + 1) * std::cos(4 * y)}));
    }
  for (uint32_t j = 0; j < uint32_t(side); ++j)
    for (uint32_t i = 0; i < uint32_t(side); ++i) {
      const uint32_t w = uint32_t(side) + 1, a = j * w + i;
      m.faces.push_back({a, a + 1, a + w});
      m.faces.push_back({a + 1, a + w + 1, a + w});
    }
  return TriangleShape(std::move(m));
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
  ShapeTraining training, resumed;
  training.add({{{ball(r.centre + Vec3d{0.05, -0.04, 0.03}, 4.03, {0.3, 1, 0.2}), ShapeRole::Mirror, 0.24, -1, {}}}});
  const auto origin = [](const ShapeTraining& t) { return std::get<SurfaceOfRevolution>(t.set()->entries[0].shape).origin; };
  constexpr ShapeRates kRates{.length = 2e-3, .angle = 1e-4};
  SplatScene ignored = r.room.scene.zeros_like();
  double first = 0;
  for (int step = 0; step < 150; ++step) {
    *r.set = *training.set();
    model.forward(r.room.scene, r.room.view, frame);
    if (step == 0) first = error();
    for (size_t i = 0; i < photo.size(); ++i) frame.grad_srgb[i] = frame.srgb[i] - photo[i];
    model.backward(r.room.scene, frame, ignored);
    training.descend(model.shape().gradients(), kRates);
    if (step != 75) continue;
    resumed = saved_and_loaded(training);
    resumed.descend(model.shape().gradients(), kRates);
    ShapeTraining once = training;
    once.descend(model.shape().gradients(), kRates);
    EXPECT_EQ(origin(resumed), origin(once)) << "a killed run goes on alike";
  }
  EXPECT_GT(first, 1e-3);
  EXPECT_LT(error(), 0.05 * first);
  // Broken gradients move nothing.
  auto broken = model.shape().gradients();
  broken[0][7] = NAN;
  const Vec3d before = origin(training);
  training.descend(broken, {.length = 1, .angle = 1});
  training.descend({}, {.length = 1, .angle = 1});
  EXPECT_EQ(origin(training), before);
  ShapeTraining none;
  none.descend({}, kRates);
  EXPECT_EQ(none.set(), nullptr);
}

// A flat sheet of triangles becomes the bumpy one whose normals it is shown.
TEST(ShapeTraining, FindsTheMeshWhoseNormalsItIsShown) {
  const Shape truth = sheet(24, 0.05);
  ShapeTraining training;
  training.add({{{sheet(24, 0), ShapeRole::Mirror, 0.1, -1, {}}}});
  Rng rng(5, 1);
  const auto error = [&](bool learn) {
    const Shape& shape = training.set()->entries[0].shape;
    std::vector<double> grad(parameter_count(shape), 0.0);
    double angle = 0;
    constexpr int kRays = 400;
    for (int k = 0; k < kRays; ++k) {
      const Ray down{{0.7 * (rng.uniform_double() - 0.5), 0.7 * (rng.uniform_double() - 0.5), 1}, {0, 0, -1}};
      const auto is = intersect(shape, down), should = intersect(truth, down);
      if (!is || !should) continue;
      const Vec3d off = is->normal - should->normal;
      hit_vjp(shape, down, *is, {0, off}, grad);
      angle += length(off) / kRays;
    }
    if (learn) training.descend({grad}, {.length = 2e-3});
    return angle;
  };
  const double before = error(false);
  ASSERT_GT(before, 0.05);
  for (int step = 0; step < 200; ++step) error(true);
  EXPECT_LT(error(false), 0.3 * before);
  ShapeTraining resumed = saved_and_loaded(training);
  std::vector<double> grad(parameter_count(truth), 0.0);
  grad[100] = 1;
  for (ShapeTraining* t : {&training, &resumed}) t->descend({grad}, {.length = 1e-3});
  const auto positions = [](const ShapeTraining& t) {
    return std::get<TriangleShape>(t.set()->entries[0].shape).mesh().positions;
  };
  EXPECT_EQ(positions(training), positions(resumed)) << "a killed run goes on alike";
}

}  // namespace
}  // namespace vitrine
