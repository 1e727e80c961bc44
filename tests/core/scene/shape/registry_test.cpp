// Every kind of shape against what its surface is: the rows of the registry are the list of tests.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/json.h"
#include "core/scene/shape/shape_file.h"
#include "core/scene/shape/shape_set.h"

namespace vitrine {
namespace {

class Shapes : public testing::TestWithParam<size_t> {
 protected:
  const ShapeKind& kind() const { return shape_kinds()[GetParam()]; }
  double unit() { return 2 * rng.uniform_double() - 1; }
  Vec3d vector() { return {unit(), unit(), unit()}; }
  Ray ray() {
    const Vec3d from = 3. * normalized(vector() + Vec3d{1e-3, 0, 0});
    return {from, 0.6 * vector() - from};
  }
  double precise() const { return std::max(kind().precision, 1e-7); }
  Rng rng{7, 1};
};

// Sphere tracing (Hart 1996) by the distances to the nearest points.
TEST_P(Shapes, RaysMeetItWhereMarchingArrives) {
  size_t hits = 0, misses = 0;
  for (int s = 0; s < 3; ++s) {
    const Shape shape = kind().sample(rng);
    for (int k = 0; k < 200; ++k) {
      const Ray r = ray();
      const double speed = length(r.direction);
      double t = 0, closest = 1e9;
      for (int i = 0; i < 4000 && t < 3; ++i) {
        const Vec3d p = r.origin + t * r.direction;
        const double d = length(nearest(shape, p).position - p);
        closest = std::min(closest, d);
        if (d < 20 * precise()) break;
        t += d / speed;
      }
      const auto hit = intersect(shape, r);
      if (hit) {
        const Vec3d p = r.origin + hit->t * r.direction;
        EXPECT_NEAR(length(nearest(shape, p).position - p), 0, 20 * precise());
        EXPECT_NEAR(length(hit->normal), 1, 1e-6);
        const double cosine = -dot(hit->normal, r.direction) / speed;
        if (cosine < 0.2) continue;
        ++hits;
        EXPECT_NEAR(hit->t * speed, t * speed, 400 * precise() / cosine) << k;
      } else {
        EXPECT_GT(closest, 20 * precise());
        ++misses;
      }
    }
  }
  EXPECT_GT(hits, 100u);
  EXPECT_GT(misses, 50u);
}

TEST_P(Shapes, NothingOfItIsNearerThanTheNearestPointNorBeyondItsBounds) {
  const Shape shape = kind().sample(rng);
  std::vector<Vec3d> surface;
  Bounds3 seen;
  for (int k = 0; k < 4000; ++k)
    if (const Ray r = ray(); const auto hit = intersect(shape, r)) {
      surface.push_back(r.origin + hit->t * r.direction);
      seen.extend(surface.back());
    }
  ASSERT_GT(surface.size(), 500u);
  const Bounds3 all = bounds(shape);
  for (const Vec3d& p : surface)
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_GE(p[c], all.low[c] - precise());
      EXPECT_LE(p[c], all.high[c] + precise());
    }
  EXPECT_LT(all.diagonal(), 1.2 * seen.diagonal());
  const Bounds3 wider = bounds(shape, 0.25);
  EXPECT_EQ(wider.low, (all.low - Vec3d{0.25, 0.25, 0.25}));
  EXPECT_EQ(wider.high, (all.high + Vec3d{0.25, 0.25, 0.25}));
  for (int k = 0; k < 100; ++k) {
    const Vec3d p = 1.5 * vector();
    const ShapePoint near = nearest(shape, p);
    EXPECT_NEAR(length(near.normal), 1, 1e-6);
    for (const Vec3d& q : surface) ASSERT_LE(length(near.position - p), length(q - p) + 20 * precise());
    const Vec3d inwards = 1e-3 * (all.centre() - near.position);  // past the edges of boxes and rectangles
    const Ray back{near.position + inwards + 0.02 * near.normal, -0.02 * near.normal};
    const auto hit = intersect(shape, back);
    ASSERT_TRUE(hit) << "it lies on the surface";
    EXPECT_NEAR(hit->t, 1, 0.2);
  }
}

TEST_P(Shapes, HitsLieOnTheFacetsThatTheyName) {
  for (int k = 0; k < 300; ++k) {
    const Shape shape = kind().sample(rng);
    const std::vector<Facet> flat = facets(shape);
    const Ray r = ray();
    const auto hit = intersect(shape, r);
    if (!hit || flat.empty()) continue;
    ASSERT_LT(hit->element, flat.size());
    EXPECT_NEAR(length(flat[hit->element].normal - hit->normal), 0, 1e-12);
    EXPECT_NEAR(dot(hit->normal, r.origin + hit->t * r.direction), flat[hit->element].offset, 1e-12);
  }
}

// A sum over many rays of what a loss may want of t and normal, parameter by parameter.
TEST_P(Shapes, SamplesLieOnItEvenly) {
  const Shape shape = kind().sample(rng);
  const double spacing = 0.03 * size_of(shape);
  const std::vector<ShapePoint> points = surface_samples(shape, spacing);
  ASSERT_GT(points.size(), 300u);
  double area = 0;
  const TriMesh mesh = tessellated(shape, spacing);
  std::vector<Vec3d> fine;
  for (const auto& f : mesh.faces) {
    const Vec3d a = cast<double>(mesh.positions[f[0]]), b = cast<double>(mesh.positions[f[1]]),
                c = cast<double>(mesh.positions[f[2]]);
    const Vec3d across = cross(b - a, c - a);
    area += 0.5 * length(across);
    const Vec3d middle = (1. / 3) * (a + b + c);
    fine.push_back(middle);
    const ShapePoint on = nearest(shape, middle);
    EXPECT_LT(length(on.position - middle), 0.3 * spacing + 20 * precise());
    if (0.5 * length(across) < 1e-3 * spacing * spacing) continue;
    EXPECT_GT(dot(normalized(across), on.normal), 0.5) << "faces look outwards";
  }
  EXPECT_NEAR(double(points.size()) * spacing * spacing / area, 1, 0.05);
  for (const ShapePoint& p : points) EXPECT_LT(length(nearest(shape, p.position).position - p.position), 20 * precise());
  for (const Vec3d& place : fine) {
    double least = 1e9;
    for (const ShapePoint& p : points) least = std::min(least, length(p.position - place));
    EXPECT_LT(least, 3.5 * spacing) << "no place without a sample";
  }
}

TEST_P(Shapes, GradientsOfHitsMatchDifferences) {
  const Shape shape = kind().sample(rng);
  const size_t n = parameter_count(shape);
  struct Asked {
    Ray ray;
    ShapeHitGrad grad;
  };
  std::vector<Asked> asked;
  std::vector<double> grad(n, 0.0), differences(n, 0.0), step(n, 0.0);
  while (asked.size() < 60) {
    const Ray r = ray();
    const auto hit = intersect(shape, r);
    if (!hit || -dot(hit->normal, r.direction) < 0.3 * length(r.direction)) continue;
    asked.push_back({r, {unit(), vector()}});
    hit_vjp(shape, r, *hit, asked.back().grad, grad);
  }
  const auto value = [&](const Shape& at, const Asked& a) -> std::optional<double> {
    const auto hit = intersect(at, a.ray);
    if (!hit) return std::nullopt;
    return a.grad.t * hit->t + dot(a.grad.normal, hit->normal);
  };
  const double h = kind().precision < 1e-8 ? 1e-6 : 1e-3;
  for (size_t i = 0; i < n; ++i) {
    step[i] = h;
    const Shape above = moved(shape, step);
    step[i] = -h;
    const Shape below = moved(shape, step);
    step[i] = 0;
    for (const Asked& a : asked) {
      const auto up = value(above, a), down = value(below, a);
      ASSERT_TRUE(up && down);
      differences[i] += (*up - *down) / (2 * h);
    }
  }
  double off = 0, all = 0;
  for (size_t i = 0; i < n; ++i) off += std::pow(grad[i] - differences[i], 2), all += std::pow(differences[i], 2);
  ASSERT_GT(all, 0);
  EXPECT_LT(std::sqrt(off / all), std::max(kind().gradient_error, 1e-4));
}

// Along the true normal, a point of the surface goes where the hit goes: n.dx = (n.d) dt.
TEST_P(Shapes, PlacesMoveWithTheSurface) {
  const Shape shape = kind().sample(rng);
  const size_t n = parameter_count(shape);
  double off = 0, all = 0;
  for (int k = 0; k < 200; ++k) {
    const Ray r = ray();
    const auto hit = intersect(shape, r);
    if (!hit || -dot(hit->normal, r.direction) < 0.3 * length(r.direction)) continue;
    const double h = kind().precision < 1e-8 ? 1e-5 : 1e-2;
    const Vec3d u = h * normalized(cross(r.direction, Vec3d{0.3, 1, 0.2})), v = h * normalized(cross(r.direction, u));
    const auto a = intersect(shape, {r.origin + u, r.direction}), b = intersect(shape, {r.origin + v, r.direction});
    if (!a || !b || a->element != hit->element || b->element != hit->element) continue;
    const Vec3d p = r.origin + hit->t * r.direction;
    const Vec3d true_normal = normalized(cross(r.origin + u + a->t * r.direction - p, r.origin + v + b->t * r.direction - p));
    std::vector<double> by_hit(n, 0.0), by_place(n, 0.0);
    hit_vjp(shape, r, *hit, {1, {}}, by_hit);
    place_vjp(shape, *hit, p, true_normal / dot(true_normal, r.direction), by_place);
    for (size_t i = 0; i < n; ++i) off += std::pow(by_hit[i] - by_place[i], 2), all += std::pow(by_hit[i], 2);
  }
  ASSERT_GT(all, 0);
  EXPECT_LT(std::sqrt(off / all), std::max(kind().gradient_error, 1e-3));
}

TEST_P(Shapes, FilesKeepIt) {
  const Shape shape = kind().sample(rng);
  const TriMesh* mesh = kind().mesh(shape);
  const auto back = kind().read(nlohmann::json::parse(kind().write(shape).dump()), mesh ? *mesh : TriMesh{});
  ASSERT_TRUE(back);
  EXPECT_EQ(back->index(), GetParam());
  EXPECT_EQ(find_shape_kind(kind().name), &kind());
  EXPECT_EQ(parameter_count(*back), parameter_count(shape));
  for (int k = 0; k < 100; ++k) {
    const Ray r = ray();
    const auto a = intersect(shape, r), b = intersect(*back, r);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (!a) continue;
    EXPECT_EQ(a->t, b->t);
    EXPECT_EQ(a->normal, b->normal);
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Shapes, testing::Range<size_t>(0, std::variant_size_v<Shape>),
                         [](const auto& info) { return std::string(shape_kinds()[info.param].name); });

}  // namespace
}  // namespace vitrine
