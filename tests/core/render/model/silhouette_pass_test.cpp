// Silhouettes of solids of revolution: how much of a pixel lies inside against counting, what moves it against differences, and
// the two pictures that a pixel there shows side by side.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/dual.h"
#include "core/render/model/gbuffer.h"
#include "core/render/model/silhouette_pixels.h"
#include "core/scene/shape/shape.h"
#include "tests/core/render/model/ball_before_wall.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

constexpr double kPi = 3.14159265358979;

TEST(EdgeInPixel, CoversWhatCountingPointsSays) {
  Rng rng(1, 1);
  for (int k = 0; k < 60; ++k) {
    const double turn = k < 8 ? k * kPi / 4 : 2 * kPi * rng.uniform_double(), d = 1.6 * rng.uniform_double() - 0.8;
    const Vec2d n{std::cos(turn), std::sin(turn)};
    constexpr int kSide = 400;
    int inside = 0;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) inside += n.x * ((x + 0.5) / kSide - 0.5) + n.y * ((y + 0.5) / kSide - 0.5) <= d;
    EXPECT_NEAR(edge_in_pixel(d, n).covered, inside / double(kSide * kSide), 2e-3) << turn << " " << d;
    using D = Dual<double, 1>;
    const auto dual = edge_in_pixel(D::variable(d, 0), Vec2<D>{D(n.x), D(n.y)});
    EXPECT_NEAR(dual.covered.d[0], edge_in_pixel(d, n).length, 1e-9);
  }
}

// A bottle with a foot: smooth sides, a shoulder, a level top.
SurfaceOfRevolution bottle(const Vec3d& at) {
  SurfaceOfRevolution s{at, normalized(Vec3d{0.2, 1, 0.1}), {{0, -0.4}, {0.2, -0.4}}};
  for (int i = 1; i < 24; ++i) s.profile.push_back({0.24 + 0.06 * std::sin(0.2 * i), -0.4 + 0.03 * i});
  s.profile.push_back({0.1, 0.36});
  s.profile.push_back({0, 0.36});
  return s;
}

View outline_camera(int side = 48) {
  View v;
  v.intrinsics = {side, side, 1.5 * side, 1.6 * side, 0.5 * side + 0.3, 0.5 * side - 0.4};
  const double angle = 0.15;
  v.cam_from_world.rotation = Mat3d{{std::cos(angle), 0, -std::sin(angle)}, {0, 1, 0}, {std::sin(angle), 0, std::cos(angle)}};
  v.cam_from_world.translation = {0.1, 0.05, 0};
  return v;
}
Vec3d before(const View& v, double z) { return inverse(v.cam_from_world) * Vec3d{0, 0, z}; }

double counted(const Shape& s, const View& v, uint32_t pixel) {
  constexpr int kSide = 24;
  const int x = int(pixel) % v.intrinsics.width, y = int(pixel) / v.intrinsics.width;
  int inside = 0;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i)
      inside += intersect(s, {v.centre_in_world(), v.ray(x + (i + 0.5) / kSide, y + (j + 0.5) / kSide)}).has_value();
  return double(inside) / (kSide * kSide);
}

TEST(Silhouettes, PixelsAreCoveredAsCountingRaysSays) {
  const View v = outline_camera();
  const SurfaceOfRevolution s = bottle(before(v, 2));
  const auto pixels = silhouette_pixels(set_of({s}), v);
  size_t crossed = 0;
  double squares = 0;
  std::vector<uint8_t> in_band(v.intrinsics.pixel_count(), 0);
  for (const SilhouettePixel& p : pixels) {
    in_band[p.pixel] = 1;
    const double truth = counted(s, v, p.pixel);
    EXPECT_NEAR(double(p.covered), truth, p.crossed ? 0.12 : 0.1) << p.pixel;
    if (p.covered > 0) {
      EXPECT_NEAR(length(p.normal), 1, 1e-5f);
    }
    if (!p.crossed) continue;
    ++crossed, squares += std::pow(double(p.covered) - truth, 2);
    EXPECT_NEAR(length(s.nearest(p.place).position - p.place), 0, 1e-3);
    EXPECT_GT(p.covered, 0);
    EXPECT_LT(p.covered, 1);
  }
  EXPECT_GT(crossed, 60u);
  EXPECT_LT(std::sqrt(squares / double(crossed)), 0.03);
  // What lies outside of the band is wholly in or wholly out.
  for (uint32_t i = 0; i < in_band.size(); i += 7) {
    if (in_band[i]) continue;
    const double truth = counted(s, v, i);
    EXPECT_TRUE(truth == 0 || truth == 1) << i;
  }
  // Behind the camera and beside the picture there is none.
  EXPECT_TRUE(silhouette_pixels(set_of({bottle(before(v, 0.1))}), v).empty());
  EXPECT_TRUE(silhouette_pixels(set_of({bottle(before(v, 2) + Vec3d{9, 0, 0})}), v).empty());
  // Nor where another solid is in the picture.
  const auto beside_it = silhouette_pixels(set_of({bottle(before(v, 0.1)), s}), v);
  ASSERT_EQ(beside_it.size(), pixels.size());
  for (size_t i = 0; i < pixels.size(); ++i) {
    EXPECT_EQ(beside_it[i].pixel, pixels[i].pixel);
    EXPECT_EQ(beside_it[i].entry, 1u);
  }
}

// ShapePass asks the same set.
TEST(Silhouettes, ShapesThatOverlapAreHitWhereTheyAreNearest) {
  const View v = outline_camera();
  const SurfaceOfRevolution back = bottle(before(v, 2));
  SurfaceOfRevolution front = back;
  front.origin += 0.2 * (v.centre_in_world() - back.origin);
  front.profile.resize(12);  // its lower half, before the whole of the other
  front.profile.push_back({0, front.profile.back().y + 0.01});
  const ShapeSet set = set_of({back, front});
  size_t inside[2] = {}, crossed[2] = {};
  for (const SilhouettePixel& p : silhouette_pixels(set, v)) {
    if (p.covered < 1 && !p.crossed) continue;
    ++(p.crossed ? crossed : inside)[p.entry];
    if (p.crossed) {
      EXPECT_NEAR(length(nearest(set.entries[p.entry].shape, p.place).position - p.place), 0, 1e-3);
      continue;
    }
    const double x = p.pixel % uint32_t(v.intrinsics.width) + 0.5, y = p.pixel / uint32_t(v.intrinsics.width) + 0.5;
    const auto hit = set.first_hit({v.centre_in_world(), v.ray(x, y)}, ShapeRole::Mirror);
    ASSERT_TRUE(hit);
    EXPECT_EQ(p.entry, hit->entry);
  }
  for (const size_t k : {0, 1}) {
    EXPECT_GT(inside[k], 10u);
    EXPECT_GT(crossed[k], 10u);
  }
}

// A box and a rectangle have silhouettes as anything else.
TEST(Silhouettes, OfFlatShapesIsTheirEdges) {
  const View v = outline_camera();
  const Vec3d at = before(v, 2);
  const Mat3d turned = rotation_matrix(normalized(Quatd{0.9, 0.3, 0.2, -0.1}));
  const Vec3d middle = transposed_times(turned, at), half{0.3, 0.2, 0.25};
  for (const Shape& shape : {Shape(Box{turned, middle - half, middle + half}), Shape(Plane{at, turned, {0.4, 0.3}})}) {
    size_t crossed = 0;
    double squares = 0;
    for (const SilhouettePixel& p : silhouette_pixels(set_of({shape}), v)) {
      if (!p.crossed) continue;
      ++crossed;
      squares += std::pow(double(p.covered) - counted(shape, v, p.pixel), 2);
    }
    EXPECT_GT(crossed, 40u);
    EXPECT_LT(std::sqrt(squares / double(crossed)), 0.08) << "a corner is no straight edge";
    // Its middle moves: the edge does.
    const size_t n = parameter_count(shape);
    const auto weight = [](uint32_t pixel) { return 1 + std::sin(0.2 * (pixel % 48)) + 0.7 * std::cos(0.1 * (pixel / 48)); };
    const auto whole = [&](const Shape& moved_shape) {
      std::vector<double> covered(48 * 48, -1);
      for (const SilhouettePixel& p : silhouette_pixels(set_of({moved_shape}), v)) covered[p.pixel] = double(p.covered);
      double sum = 0;
      for (uint32_t i = 0; i < covered.size(); ++i) {
        if (covered[i] < 0) covered[i] = counted(moved_shape, v, i) > 0.5;
        sum += weight(i) * covered[i];
      }
      return sum;
    };
    std::vector<double> g(n, 0.0), step(n, 0.0), differences;
    for (const SilhouettePixel& p : silhouette_pixels(set_of({shape}), v))
      if (p.crossed) silhouette_vjp(p, shape, weight(p.pixel), g);
    for (size_t i = 0; i < n; ++i)
      differences.push_back(finite_difference(
          step[i], [&] { return whole(moved(shape, step)); }, 5e-3));
    expect_grad_close(std::vector<float>(g.begin(), g.end()), differences, {.relative_l2 = 0.1, .bias = 0.1, .row_floor = 0.1},
                      "edges");
  }
}

// A weight that varies over the picture, times what is covered: the solid's numbers against differences.
TEST(Silhouettes, GradientsMatchDifferences) {
  constexpr uint32_t kSide = 192;
  const View v = outline_camera(kSide);
  SurfaceOfRevolution s = bottle(before(v, 2));
  const auto weight = [&](uint32_t pixel) {
    const double x = double(pixel % kSide) / kSide, y = double(pixel / kSide) / kSide;
    return 1 + std::sin(5 * x) + 0.7 * std::cos(4 * y + x);
  };
  std::vector<double> g(parameter_count(s), 0.0);
  for (const SilhouettePixel& p : silhouette_pixels(set_of({s}), v))
    if (p.crossed) silhouette_vjp(p, s, weight(p.pixel), g);
  std::vector<float> exact;
  std::vector<double> differences;
  // Deeper inside than the band every pixel is covered.
  const auto whole = [&] {
    std::vector<double> covered(size_t(kSide) * kSide, -1);
    for (const SilhouettePixel& p : silhouette_pixels(set_of({s}), v)) covered[p.pixel] = double(p.covered);
    double out = 0;
    for (uint32_t i = 0; i < covered.size(); ++i) {
      if (covered[i] < 0) covered[i] = s.intersect({v.centre_in_world(), v.ray(i % kSide + 0.5, i / kSide + 0.5)}).has_value();
      out += weight(i) * covered[i];
    }
    return out;
  };
  const SurfaceOfRevolution at = s;
  const auto differ = [&](size_t first, size_t last, double step, const GradTolerance& tolerance, const char* parameters) {
    exact.clear(), differences.clear();
    for (size_t i = first; i < last; ++i) {
      std::vector<double> by(g.size(), 0.0);
      const auto moved_by = [&] {
        s = at.moved(by);
        return whole();
      };
      exact.push_back(float(g[i])), differences.push_back(finite_difference(by[i], moved_by, step));
    }
    s = at;
    expect_grad_close(exact, differences, tolerance, parameters);
  };
  differ(0, 2, 3e-3, {.relative_l2 = 2e-2, .bias = 2e-2, .row_floor = 0.05}, "origin");
  differ(2, 4, 5e-3, {.relative_l2 = 3e-2, .bias = 3e-2, .row_floor = 0.1}, "axis");
  differ(5, g.size() - 1, 2e-3, {.relative_l2 = 8e-2, .bias = 5e-2, .row_floor = 0.15}, "profile");
}

TEST(SilhouettePass, PixelsShowTheSolidAndWhatIsBehindItSideBySide) {
  BallBeforeWall b;
  LayeredModel model(b.options);
  Frame frame, wall;
  model.forward(b.room.scene, b.room.view, frame);
  SplatScene behind = b.room.scene;
  behind.diffuse = SplatLayer(LayerKind::Diffuse, 1, 1);
  for (const AttributeRow& r : kAttributes)
    std::copy_n(b.room.scene.diffuse.at(r.id, b.of_ball), behind.diffuse.width(r.id), behind.diffuse.at(r.id, 0));
  LayeredModel(b.options).forward(behind, b.room.view, wall);
  ASSERT_GT(frame.silhouette.pixels.size(), 200u);
  const size_t pixels = frame.pixel_count();
  size_t kinds[3] = {};
  for (size_t i = 0; i < frame.silhouette.pixels.size(); ++i) {
    const SilhouettePixel& p = frame.silhouette.pixels[i];
    const auto linear = [&](const Frame& f, size_t c) { return f.linear[c * pixels + p.pixel]; };
    ++kinds[p.covered == 0 ? 0 : p.covered < 1 ? 1 : 2];
    for (size_t c = 0; c < 3; ++c) {
      if (p.covered == 0) {
        EXPECT_NEAR(linear(frame, c), linear(wall, c), 1e-5f) << "no blur of the ball outside of it";
      }
      if (!p.crossed) continue;
      EXPECT_NEAR(linear(frame, c), p.covered * frame.silhouette.solid[3 * i + c] + (1 - p.covered) * linear(wall, c), 1e-5f);
    }
    if (p.covered < 1) continue;
    const GBuffer g(frame);
    const Vec3f n = normalized(g.rgb(g.normal, p.pixel));
    const Vec3d place = cast<double>(g.ray(p.pixel).eye) + double(p.z) * cast<double>(g.ray(p.pixel).direction_per_z);
    EXPECT_GT(dot(cast<double>(n), normalized(place - b.centre)), 0.999) << "turned as the solid, up to its edge";
  }
  for (size_t k : kinds) EXPECT_GT(k, 30u);

  // A hand in front of the ball, and a ball that is not polished: as before.
  const auto as_before = [&](const SplatScene& scene) {
    ImageOptions off = b.options;
    off.shape.silhouettes = false;
    Frame with, without;
    LayeredModel(b.options).forward(scene, b.room.view, with);
    LayeredModel(off).forward(scene, b.room.view, without);
    return with.srgb == without.srgb;
  };
  EXPECT_FALSE(as_before(b.room.scene));
  SplatScene hidden = b.room.scene, dull = b.room.scene;
  const size_t hand = add_surfel(hidden.diffuse, {.mean = {0, 0, 1.2}, .normal = {0, 0, -1}, .size = 2, .opacity = 0.999}, 5);
  *hidden.diffuse.at(Attribute::SpecularWeight, hand) = *hidden.diffuse.at(Attribute::Transmission, hand) = -7;
  EXPECT_TRUE(as_before(hidden));
  for (size_t i = 0; i < b.of_ball; ++i) *dull.diffuse.at(Attribute::SpecularWeight, i) = -3;
  EXPECT_TRUE(as_before(dull));
}

TEST(SilhouettePass, GradientsMatchDifferences) {
  BallBeforeWall b;
  LayeredModel model(b.options);
  Frame frame;
  const auto loss = [&] {
    model.forward(b.room.scene, b.room.view, frame);
    return loss_of(frame);
  };
  loss();
  start_gradient(frame);
  SplatScene grad = b.room.scene.zeros_like();
  model.backward(b.room.scene, frame, grad);
  std::vector<float> exact;
  std::vector<double> differences;
  const auto number = [&](double gradient, auto& value, double step) {
    exact.push_back(float(gradient)), differences.push_back(finite_difference(value, loss, step));
  };
  const std::vector<double> of_ball = model.shape().gradients().at(0);
  const Shape at = b.set->entries[0].shape;
  std::vector<double> by(of_ball.size(), 0.0);
  for (size_t i = 0; i < 2; ++i) {
    const auto moved_by = [&] {
      b.set->entries[0].shape = moved(at, by);
      return loss();
    };
    exact.push_back(float(of_ball[i])), differences.push_back(finite_difference(by[i], moved_by, 2e-4));
  }
  b.set->entries[0].shape = at;
  // What a crossed pixel mirrors moves along, which counts for nothing.
  expect_grad_close(exact, differences, {.relative_l2 = 0.12, .bias = 0.12, .row_floor = 0.1}, "place of the ball");
  // The wall and every fifth surfel of the ball; where those stand, is a matter of which pixels show the ball at all.
  for (const Attribute a :
       {Attribute::Mean, Attribute::Rotation, Attribute::ShDc, Attribute::Opacity, Attribute::F0, Attribute::SpecularWeight}) {
    exact.clear(), differences.clear();
    for (size_t i = 0; i < b.room.scene.diffuse.size(); ++i) {
      if (b.is_ball(i) && (i % 5 != 0 || a == Attribute::Mean || a == Attribute::Rotation)) continue;
      for (size_t c = 0; c < b.room.scene.diffuse.width(a); ++c)
        number(double(grad.diffuse.at(a, i)[c]), b.room.scene.diffuse.at(a, i)[c], 1e-3);
    }
    expect_grad_close(exact, differences, {.relative_l2 = 5e-2, .bias = 5e-2, .row_floor = 0.1}, std::string(row(a).name));
  }
}

}  // namespace
}  // namespace vitrine
