// Every kernel's reverse against dual numbers pushed through its forward, and identities that hold without derivatives.
#include <gtest/gtest.h>

#include <iostream>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/dual.h"
#include "core/render/raster/kernels/blend.h"
#include "core/render/raster/kernels/project.h"
#include "core/render/raster/kernels/shade.h"
#include "core/render/raster/kernels/splat_weight.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

constexpr GradTolerance kExact{.relative_l2 = 1e-11, .bias = 1e-11};  // worst seen: printed by each test

void report(const char* kernel, double worst) {
  std::cout << kernel << ": worst relative L2 " << worst << "\n";
  testing::Test::RecordProperty(kernel, std::to_string(worst));
}

template <class T>
Camera<T> test_camera() {
  const Mat3d r = rotation_matrix(normalized(Quatd{0.9, 0.1, -0.2, 0.15}));
  const Vec3d t{0.1, -0.05, 0.3};
  const Vec3d eye = -transposed_times(r, t);
  return {T(60.0), T(58.0), T(17.0), T(13.0), cast<T>(r), cast<T>(t), cast<T>(eye)};
}

// Nine raw values of a surfel that lies before the camera.
std::vector<double> random_geometry(Rng& rng) {
  const Camera<double> c = test_camera<double>();
  const Vec3d in_cam{0.3 * rng.normal(), 0.3 * rng.normal(), 2.0 + rng.uniform_double()};
  const Vec3d mean = transposed_times(c.rotation, in_cam - c.translation);
  return {mean.x,
          mean.y,
          mean.z,
          rng.normal(),
          rng.normal(),
          rng.normal(),
          rng.normal(),
          -1 + 0.3 * rng.normal(),
          -1.5 + 0.3 * rng.normal()};
}
template <class T>
SurfelGeometry<T> geometry(const std::vector<T>& x) {
  return {{x[0], x[1], x[2]}, {x[3], x[4], x[5], x[6]}, x[7], x[8]};
}
template <size_t N>
std::vector<Dual<double, N>> variables(const std::vector<double>& x) {
  std::vector<Dual<double, N>> out;
  for (size_t i = 0; i < x.size(); ++i) out.push_back(Dual<double, N>::variable(x[i], i));
  return out;
}
template <size_t N>
std::vector<double> derivatives(const Dual<double, N>& f) {
  return {f.d.begin(), f.d.end()};
}

TEST(ProjectVjp, MatchesDualNumbers) {
  Rng rng(1);
  double worst = 0;
  for (int trial = 0; trial < 50; ++trial) {
    using D = Dual<double, 9>;
    const std::vector<double> x = random_geometry(rng);
    double up[12];
    for (double& u : up) u = rng.normal();
    const Projection<D> p = project(geometry(variables<9>(x)), test_camera<D>());
    const D outputs[12] = {p.map.cx,  p.map.cy, p.map.z0, p.map.m00,  p.map.m01,  p.map.m10,
                           p.map.m11, p.map.h0, p.map.h1, p.normal.x, p.normal.y, p.normal.z};
    D loss(0);
    for (int i = 0; i < 12; ++i) loss += D(up[i]) * outputs[i];
    const SurfelGeometry<double> s = geometry(x);
    const auto camera = test_camera<double>();
    const ScreenMap<double> grad{up[0], up[1], up[2], up[3], up[4], up[5], up[6], up[7], up[8]};
    const auto g = project_vjp(s, camera, project(s, camera), grad, Vec3d{up[9], up[10], up[11]}).surfel;
    const std::vector<double> actual{g.mean.x,     g.mean.y,     g.mean.z, g.rotation.w, g.rotation.x,
                                     g.rotation.y, g.rotation.z, g.log_su, g.log_sv};
    worst = std::max(worst, expect_grad_close(actual, derivatives(loss), {.relative_l2 = 1e-10, .bias = 1e-10}).relative_l2);
  }
  report("project", worst);
}

// The 2DGS paper's form: planes x = px and y = py pulled back to (u, v, 1), and their cross product.
TEST(SplatSample, IsTheIntersectionOfPixelPlanesAndOfTheWorldRay) {
  Rng rng(2);
  double worst = 0;
  const auto camera = test_camera<double>();
  for (int trial = 0; trial < 200; ++trial) {
    const SurfelGeometry<double> s = geometry(random_geometry(rng));
    const auto p = project(s, camera);
    const double px = p.map.cx + rng.normal(), py = p.map.cy + rng.normal();
    const auto f = splat_sample<double>(SplatConstants<double>{p.map, 0.9, 0.01, kNoLowPass}, px, py);
    const Vec3d a0 = camera.rotation * s.mean + camera.translation;
    const auto homogeneous = [&](double focal, double centre, size_t axis) {
      const auto at = [&](const Vec3d& a) { return focal * a[axis] + centre * a.z; };
      return Vec3d{at(p.a_u), at(p.a_v), at(a0)};
    };
    const Vec3d tu = homogeneous(camera.fx, camera.cx, 0), tv = homogeneous(camera.fy, camera.cy, 1), tw{p.a_u.z, p.a_v.z, a0.z};
    const Vec3d q = cross(px * tw - tu, py * tw - tv);
    const double u = q.x / q.z, v = q.y / q.z, z = u * tw.x + v * tw.y + tw.z;
    const Vec3d d = transposed_times(camera.rotation, Vec3d{(px - camera.cx) / camera.fx, (py - camera.cy) / camera.fy, 1.0});
    const double t = dot(p.frame.c2, s.mean - camera.eye) / dot(p.frame.c2, d);
    const Vec3d offset = camera.eye + t * d - s.mean;
    const double scale = 1 + std::abs(u) + std::abs(v) + std::abs(z);
    for (double e :
         {f.u - u, f.v - v, f.z - z, f.u - dot(p.frame.c0, offset) / p.su, f.v - dot(p.frame.c1, offset) / p.sv, f.z - t})
      worst = std::max(worst, std::abs(e) / scale);
  }
  EXPECT_LT(worst, 1e-10);
  report("intersection", worst);
}

TEST(SplatSampleVjp, MatchesDualNumbersOnBothBranchesAndAtTheClamp) {
  Rng rng(3);
  double worst = 0;
  int on_plane = 0, on_disc = 0, clamped = 0;
  for (int trial = 0; trial < 300; ++trial) {
    using D = Dual<double, 10>;
    std::vector<double> x{10,
                          12,
                          2,
                          rng.normal(),
                          rng.normal(),
                          rng.normal(),
                          rng.normal(),
                          0.05 * rng.normal(),
                          0.05 * rng.normal(),
                          trial % 3 == 0 ? 7.0 : rng.normal()};
    const double px = 10 + 0.6 * rng.normal(), py = 12 + 0.6 * rng.normal(), up_alpha = rng.normal();
    const auto constants = [](const auto& v) {
      using T = std::decay_t<decltype(v[0])>;
      return SplatConstants<T>{
          {v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8]}, T(1) / (T(1) + exp(-v[9])), T(0.1), T(kLowPassInvVariance)};
    };
    const auto f = splat_sample<double>(constants(x), px, py);
    if (!f.counts) continue;
    f.on_plane ? ++on_plane : ++on_disc;
    clamped += !f.free;
    const double up_z = rng.normal();
    const auto dual = splat_sample<D>(constants(variables<10>(x)), D(px), D(py));
    const D loss = D(up_alpha) * dual.alpha + D(up_z) * dual.z;
    SplatMoments<double> m;
    m.add(splat_sample_vjp(f, up_alpha, up_z), f.dx, f.dy);
    const auto c = constants(x);
    const SplatGrad<double> g = splat_grad(m, c.map, c.opacity);
    const std::vector<double> actual{g.map.cx,  g.map.cy,  g.map.z0, g.map.m00, g.map.m01,
                                     g.map.m10, g.map.m11, g.map.h0, g.map.h1,  g.raw_opacity};
    worst = std::max(worst, expect_grad_close(actual, derivatives(loss), kExact).relative_l2);
  }
  EXPECT_GT(on_plane, 50);
  EXPECT_GT(on_disc, 50);
  EXPECT_GT(clamped, 5);
  report("splat_weight", worst);
}

TEST(ShColourVjp, MatchesDualNumbersInCoefficientsAndMean) {
  Rng rng(4);
  double worst = 0;
  for (int degree = 0; degree <= 3; ++degree) {
    using D = Dual<double, 51>;
    std::vector<double> x(51, 0.0);
    for (double& v : x) v = 0.4 * rng.normal();
    x[50] += 2;
    const Vec3d eye{0.1, 0.2, -1}, up{rng.normal(), rng.normal(), rng.normal()};
    const auto v = variables<51>(x);
    const auto dual = sh_colour<D>(degree, {v[48], v[49], v[50]}, cast<D>(eye), v.data());
    const D loss = D(up.x) * dual.value.x + D(up.y) * dual.value.y + D(up.z) * dual.value.z;
    std::vector<double> actual(51, 0.0);
    const auto colour = sh_colour<double>(degree, {x[48], x[49], x[50]}, eye, x.data());
    const Vec3d mean = sh_colour_vjp(degree, colour, x.data(), up, actual.data());
    for (size_t c = 0; c < 3; ++c) actual[48 + c] = mean[c];
    worst = std::max(worst, expect_grad_close(actual, derivatives(loss), kExact).relative_l2);
  }
  report("shade", worst);
}

// Alphas, values and depths of four fragments, in order.
TEST(BlendVjp, MatchesDualNumbersIncludingDistortion) {
  using D = Dual<double, 8>;
  Rng rng(5);
  double worst = 0;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> x;
    for (int i = 0; i < 4; ++i) x.push_back(trial % 2 ? 0.95 : 0.1 + 0.6 * rng.uniform_double());
    for (int i = 0; i < 4; ++i) x.push_back(1.0 + i + rng.uniform_double());
    std::vector<double> colour;
    for (int i = 0; i < 4; ++i) colour.push_back(rng.normal());
    const double pivot = 0.4;
    const auto v = variables<8>(x);
    D transmittance(1), loss(0);
    DistortionSums<D> sums;
    for (size_t i = 0; i < 4; ++i) {
      const D w = blend_weight(v[i], transmittance);
      loss += w * D(colour[i]);
      sums.add(w, D(1) / v[4 + i] - D(pivot));
      transmittance *= D(1) - v[i];
    }
    loss += D(30.0) * sums.value();
    DistortionSums<double> totals;
    std::vector<double> front{1};
    for (size_t i = 0; i < 4; ++i) {
      totals.add(blend_weight(x[i], front[i]), 1 / x[4 + i] - pivot);
      front.push_back(front[i] * (1 - x[i]));
    }
    std::vector<double> actual(8, 0.0);
    double behind = 0;
    for (size_t i = 4; i-- > 0;) {
      const double q = 1 / x[4 + i] - pivot, w = blend_weight(x[i], front[i]), value = colour[i] + 30 * totals.weight_slope(q);
      actual[i] = blend_vjp(front[i], value, behind, 1 / (1 - x[i]));
      actual[4 + i] = 30 * totals.depth_slope(w, q, 1 / x[4 + i]);
      behind += w * value;
    }
    worst = std::max(worst, expect_grad_close(actual, derivatives(loss), kExact).relative_l2);
  }
  report("blend", worst);
}

}  // namespace
}  // namespace vitrine
