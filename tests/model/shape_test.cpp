// Specular pixels whose surface a surface of revolution gives; what a picture asks of its parameters against differences.
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/mesh_topology.h"
#include "core/model/gbuffer.h"
#include "core/model/shape_mesh.h"
#include "core/shape/shape.h"
#include "core/train/shape_training.h"
#include "tests/model/exact_model.h"
#include "tests/model/tiny_rooms.h"
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
  std::shared_ptr<std::vector<SurfaceOfRevolution>> shapes = std::make_shared<std::vector<SurfaceOfRevolution>>();
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
  model.options().shape.polished = 0.95f;
  EXPECT_TRUE(own());
  model.options().shape = r.options.shape;
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
  EXPECT_NE(model.shape().gradients().at(0).at(0), 0);
  ASSERT_EQ(model.shape().beside_gradient().size(), 4u);
  for (double v : model.shape().beside_gradient()) EXPECT_NE(v, 0);
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
  ASSERT_EQ(model.shape().gradients().size(), 1u);
  const std::vector<double> g = model.shape().gradients()[0];
  const SurfaceOfRevolution at = (*r.shapes)[0];
  std::vector<float> exact;
  std::vector<double> differences, step(g.size(), 0.0);
  const auto number = [&](size_t i) {
    constexpr double kStep = 2e-3;
    double loss[2];
    for (const size_t side : {0, 1}) {
      step[i] = side == 0 ? -kStep : kStep;
      (*r.shapes)[0] = at.moved(step);
      loss[side] = r.loss(model, frame);
    }
    step[i] = 0;
    (*r.shapes)[0] = at;
    exact.push_back(static_cast<float>(g[i])), differences.push_back((loss[1] - loss[0]) / (2 * kStep));
  };
  for (size_t i = 0; i < 4; ++i) number(i);
  expect_grad_close(exact, differences, {.relative_l2 = 2e-2, .bias = 2e-2, .row_floor = 0.05}, "axis");
  exact.clear(), differences.clear();
  for (size_t i = 4; i < g.size(); ++i) number(i);
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
    training.descend(model.shape().gradients(), {.origin = 2e-3, .axis = 1e-4, .profile = 1e-3});
    if (step != 75) continue;
    ArchiveWriter out;
    training.save(out);
    ArchiveReader in(out.bytes());
    resumed.load(in);
    EXPECT_TRUE(in.at_end());
    resumed.descend(model.shape().gradients(), {.origin = 2e-3, .axis = 1e-4, .profile = 1e-3});
    ShapeTraining once = training;
    once.descend(model.shape().gradients(), {.origin = 2e-3, .axis = 1e-4, .profile = 1e-3});
    EXPECT_EQ(resumed.shapes()[0].origin, once.shapes()[0].origin) << "a killed run goes on alike";
  }
  EXPECT_GT(first, 1e-3);
  EXPECT_LT(error(), 0.05 * first);
  // Broken gradients move nothing.
  auto broken = model.shape().gradients();
  broken[0][7] = NAN;
  const Vec3d before = training.shapes()[0].origin;
  training.descend(broken, {.origin = 1, .axis = 1, .profile = 1});
  EXPECT_EQ(training.shapes()[0].origin, before);
}

}  // namespace
}  // namespace vitrine
