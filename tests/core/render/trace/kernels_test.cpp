// The tracer's kernels and the whole reference tracer: reverse against dual numbers pushed through the forward, and against
// finite differences; identities that hold without derivatives.
#include <gtest/gtest.h>

#include <iostream>

#include "core/foundation/math/dual.h"
#include "core/render/trace/reference/reference_trace.h"
#include "tests/core/render/trace/ray_scenes.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

using namespace reference;

constexpr GradTolerance kExact{.relative_l2 = 1e-10, .bias = 1e-10};  // worst seen: printed by each test

// Everything that a loss can depend on, as one list of numbers: raw values of surfels, then of rays (origin, direction).
struct Variables {
  std::vector<SurfelValues<double>> surfels;
  std::vector<TraceRay<double>> rays;
};

Variables variables_of(const RayScene& scene) {
  Variables v;
  v.surfels.resize(scene.layer.size());
  for (size_t i = 0; i < v.surfels.size(); ++i)
    visit_values(scene.layer, v.surfels[i], [&](double& x, Attribute a, size_t c) { x = double(scene.layer.at(a, i)[c]); });
  for (size_t i = 0; i < scene.origins.size(); ++i)
    v.rays.push_back({cast<double>(scene.origins[i]), cast<double>(scene.directions[i]), scene.near.empty() ? 0 : scene.near[i],
                      scene.far.empty() ? 1e30 : scene.far[i]});
  return v;
}

template <class T>
MarchDesc<T> march_desc(const RayScene& scene) {
  return {std::min(scene.desc.sh_degree, scene.layer.sh_degree()), T(double(scene.desc.min_transmittance)),
          T(double(scene.desc.first_hit_weight))};
}

MarchValues<double> upstream(const RayValues& g, size_t i) {
  return {cast<double>(g.color[i]), g.transmittance[i], g.distance[i], g.first_hit[i], cast<double>(g.normal[i])};
}

template <class T>
T loss_of_ray(const RayScene& scene, const std::vector<TraceSurfel<T>>& surfels, const TraceRay<T>& ray, const RayValues& grad,
              size_t i) {
  std::vector<BlendedHit<T>> hits;
  const MarchValues<T> v = trace_ray(surfels, ray, march_desc<T>(scene), hits);
  const MarchValues<double> g = upstream(grad, i);
  return dot(v.color, cast<T>(g.color)) + v.transmittance * T(g.transmittance) + v.distance * T(g.distance) +
         v.first_hit * T(g.first_hit) + dot(v.normal, cast<T>(g.normal));
}

template <class T>
TraceRay<T> ray_as(const TraceRay<double>& r) {
  return {cast<T>(r.origin), cast<T>(r.direction), T(r.near), T(r.far)};
}

struct Gradients {
  std::vector<TraceSums<double>> sums;
  std::vector<RayGrad<double>> rays;
};
Gradients backward(const RayScene& scene, const Variables& at, const RayValues& grad) {
  std::vector<TraceSurfel<double>> surfels;
  for (const auto& s : at.surfels) surfels.push_back(trace_surfel(s));
  Gradients out;
  out.sums.resize(surfels.size());
  std::vector<BlendedHit<double>> hits;
  for (size_t i = 0; i < at.rays.size(); ++i) {
    const auto desc = march_desc<double>(scene);
    const MarchValues<double> v = trace_ray(surfels, at.rays[i], desc, hits);
    out.rays.push_back(trace_ray_vjp(surfels, at.rays[i], desc, hits, v, upstream(grad, i), 0.0, out.sums));
  }
  return out;
}

std::vector<double> surfel_gradient(const RayScene& scene, const Variables& at, const Gradients& g, size_t of) {
  SurfelValues<double> raw;
  const auto shape = ray_surfel_vjp(at.surfels[of].geometry, sigmoid(at.surfels[of].opacity), g.sums[of].moments);
  raw.geometry = shape.geometry;
  raw.opacity = shape.raw_opacity;
  raw.sh = g.sums[of].sh;
  std::vector<double> out;
  visit_values(scene.layer, raw, [&](double& v, Attribute, size_t) { out.push_back(v); });
  return out;
}

TEST(TracerBackward, MatchesDualNumbersForEveryRawValueOfSurfels) {
  using D = Dual<double, 64>;
  double worst = 0;
  size_t compared = 0;
  for (const RayScene& scene : ray_scenes()) {
    SCOPED_TRACE(scene.name);
    const Variables at = variables_of(scene);
    const RayValues grad = random_gradients(at.rays.size(), 7);
    const Gradients gradients = backward(scene, at, grad);
    for (size_t of = 0; of < std::min<size_t>(at.surfels.size(), 6); ++of) {
      std::vector<TraceSurfel<D>> surfels;
      for (size_t i = 0; i < at.surfels.size(); ++i) {
        std::vector<double> plain;
        SurfelValues<double> copy = at.surfels[i];
        visit_values(scene.layer, copy, [&](double& v, Attribute, size_t) { plain.push_back(v); });
        SurfelValues<D> values;
        size_t n = 0;
        visit_values(scene.layer, values, [&](D& v, Attribute, size_t) {
          v = i == of ? D::variable(plain[n], n) : D(plain[n]);
          ++n;
        });
        surfels.push_back(trace_surfel(values));
      }
      D loss(0);
      for (size_t i = 0; i < at.rays.size(); ++i) loss += loss_of_ray(scene, surfels, ray_as<D>(at.rays[i]), grad, i);
      const std::vector<double> actual = surfel_gradient(scene, at, gradients, of);
      const std::vector<double> expected(loss.d.begin(), loss.d.begin() + static_cast<long>(actual.size()));
      const GradReport r = compare_gradients<double, double>(actual, expected, kExact);
      if (r.norm == 0) continue;  // no ray meets it
      ++compared;
      EXPECT_EQ(r.problem(kExact), "") << "surfel " << of << ": " << r.relative_l2;
      worst = std::max(worst, r.relative_l2);
    }
  }
  EXPECT_GE(compared, 28u);
  std::cout << "surfels against dual numbers: worst relative L2 " << worst << " over " << compared << "\n";
}

TEST(TracerBackward, MatchesDualNumbersForOriginAndDirection) {
  using D = Dual<double, 6>;
  double worst = 0;
  for (const RayScene& scene : ray_scenes()) {
    SCOPED_TRACE(scene.name);
    const Variables at = variables_of(scene);
    const RayValues grad = random_gradients(at.rays.size(), 8);
    const Gradients gradients = backward(scene, at, grad);
    std::vector<TraceSurfel<D>> surfels;
    for (const auto& s : at.surfels) {
      SurfelValues<D> values;
      SurfelValues<double> copy = s;
      std::vector<double> plain;
      visit_values(scene.layer, copy, [&](double& v, Attribute, size_t) { plain.push_back(v); });
      size_t n = 0;
      visit_values(scene.layer, values, [&](D& v, Attribute, size_t) { v = D(plain[n++]); });
      surfels.push_back(trace_surfel(values));
    }
    std::vector<double> actual, expected;
    for (size_t i = 0; i < at.rays.size(); ++i) {
      TraceRay<D> ray = ray_as<D>(at.rays[i]);
      for (size_t c = 0; c < 3; ++c) {
        ray.origin[c] = D::variable(at.rays[i].origin[c], c);
        ray.direction[c] = D::variable(at.rays[i].direction[c], 3 + c);
      }
      const D loss = loss_of_ray(scene, surfels, ray, grad, i);
      expected.insert(expected.end(), loss.d.begin(), loss.d.end());
      const RayGrad<double>& g = gradients.rays[i];
      actual.insert(actual.end(), {g.origin.x, g.origin.y, g.origin.z, g.direction.x, g.direction.y, g.direction.z});
    }
    worst = std::max(worst, expect_grad_close(actual, expected, kExact, scene.name).relative_l2);
  }
  std::cout << "rays against dual numbers: worst relative L2 " << worst << "\n";
}

TEST(TracerBackward, MatchesFiniteDifferences) {
  double worst = 0;
  for (const RayScene& scene : ray_scenes()) {
    if (scene.name != "one" && scene.name != "intersecting" && scene.name != "opaque_stack") continue;
    Variables at = variables_of(scene);
    const RayValues grad = random_gradients(at.rays.size(), 9);
    const Gradients gradients = backward(scene, at, grad);
    std::vector<double> x, actual = surfel_gradient(scene, at, gradients, 0);
    const auto visit = [&](auto body) {
      visit_values(scene.layer, at.surfels[0], [&](double& v, Attribute, size_t) { body(v); });
      for (TraceRay<double>& r : at.rays)
        for (size_t c = 0; c < 3; ++c) body(r.origin[c]), body(r.direction[c]);
    };
    for (const RayGrad<double>& g : gradients.rays)
      for (size_t c = 0; c < 3; ++c) actual.insert(actual.end(), {g.origin[c], g.direction[c]});
    visit([&](double& v) { x.push_back(v); });
    const std::vector<double> expected = finite_differences(
        x,
        [&] {
          size_t n = 0;
          visit([&](double& v) { v = x[n++]; });
          std::vector<TraceSurfel<double>> surfels;
          for (const auto& s : at.surfels) surfels.push_back(trace_surfel(s));
          double sum = 0;
          for (size_t i = 0; i < at.rays.size(); ++i) sum += loss_of_ray(scene, surfels, at.rays[i], grad, i);
          return sum;
        },
        1e-7);
    worst = std::max(worst, expect_grad_close(actual, expected, {.relative_l2 = 1e-5, .bias = 1e-5}, scene.name).relative_l2);
  }
  std::cout << "against finite differences: worst relative L2 " << worst << "\n";
}

TEST(RaySplat, MeetsThePlaneWhereTheSurfelIs) {
  const SurfelGeometry<double> raw{{0.2, -0.1, 0.7}, {0.9, 0.3, -0.2, 0.5}, std::log(0.3), std::log(0.2)};
  const RaySurfel<double> s = ray_surfel(raw, 0.8);
  const Mat3d frame = rotation_matrix(normalized(raw.rotation));
  const Vec3d target = raw.mean + 0.3 * 1.2 * frame.c0 - 0.2 * 0.4 * frame.c1, origin{0.3, 0.5, -1};
  const TraceRay<double> ray{origin, normalized(target - origin), 0, 10};
  const RayHit<double> hit = ray_splat(s, ray);
  ASSERT_TRUE(hit.counts);
  EXPECT_NEAR(hit.t, length(target - origin), 1e-12);
  EXPECT_NEAR(hit.u, 1.2, 1e-12);
  EXPECT_NEAR(hit.v, -0.4, 1e-12);
  EXPECT_NEAR(hit.alpha, 0.8 * std::exp(-0.5 * (1.2 * 1.2 + 0.4 * 0.4)), 1e-12);
}

}  // namespace
}  // namespace vitrine
