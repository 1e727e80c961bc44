#include "core/render/relight/microfacet.h"

#include <gtest/gtest.h>

#include "core/render/relight/sample_points.h"

namespace vitrine {
namespace {

constexpr float kTurn = 2 * Microfacet::kPi;

Vec3f view_at(float cosine) { return {std::sqrt(1 - cosine * cosine), 0, cosine}; }

std::vector<RelitMaterial> materials() {
  std::vector<RelitMaterial> out;
  for (const float roughness : {0.2f, 0.5f, 0.9f})
    for (const float specular : {0.f, 0.02f, 0.3f, 1.f})
      for (const float f0 : {0.04f, 0.9f})
        for (const float tau : {0.f, 0.7f}) out.push_back({{1, 0.8f, 0.3f}, {f0, f0, 0.5f * f0}, roughness, specular, tau});
  for (const float roughness : {0.5f, 0.7f})
    for (const float anisotropy : {0.4f, 0.9f})
      out.push_back(
          {.albedo = {1, 0.8f, 0.3f}, .f0 = {0.9f, 0.9f, 0.5f}, .roughness = roughness, .specular = 1, .anisotropy = anisotropy});
  return out;
}

// Quadrature over the hemisphere: azimuth and n.l^2.
template <class F>
double over_hemisphere(const F& f, int n = 200) {
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double z = (i + 0.5) / n, phi = kTurn * (j + 0.5) / n, r = std::sqrt(1 - z * z);
      sum += f(Vec3f{float(r * std::cos(phi)), float(r * std::sin(phi)), float(z)}) * kTurn / (double(n) * n);
    }
  return sum;
}

TEST(Microfacet, NeverSendsMoreLightThanItGets) {
  for (const LayerBlend blend : {LayerBlend::Layered, LayerBlend::RtrGs})
    for (const float cosine : {0.05f, 0.3f, 0.7f, 1.f})
      for (const RelitMaterial& m : materials()) {
        const Microfacet f(blend, m, view_at(cosine));
        const double out = over_hemisphere([&](const Vec3f& l) { return f.value(l).x; }, 100);
        EXPECT_LE(out + f.transmission_weight().x, 1.002)
            << int(blend) << " cos " << cosine << " rough " << m.roughness << " ks " << m.specular << " f0 " << m.f0.x;
      }
}

TEST(Microfacet, BrushedMetalIsRougherAcrossItsMarks) {
  const RelitMaterial brushed{.f0 = {1, 1, 1}, .roughness = 0.3f, .specular = 1, .anisotropy = 0.8f};
  const Microfacet f(LayerBlend::Layered, brushed, {0, 0, 1});
  const float side = 0.5f, up = std::sqrt(1 - side * side);
  const float across = f.value({side, 0, up}).x, along = f.value({0, side, up}).x;
  EXPECT_GT(across, 5 * along);
  // The density of the half vectors is that of an ellipsoid: it integrates to 1 over the projected hemisphere.
  const double visible = over_hemisphere([&](const Vec3f& h) {
    const Vec3f l = h.z * 2.f * h - Vec3f{0, 0, 1};
    return l.z > 0 ? 4 * double(h.z) * f.pdf(l) : 0;
  });
  EXPECT_GT(visible, 0.8);  // the rest is reflected below the horizon
  EXPECT_LT(visible, 1.01);
  // Reciprocity: value is f n.l.
  const Vec3f a = normalized(Vec3f{0.3f, 0.5f, 0.8f}), b = normalized(Vec3f{-0.6f, 0.2f, 0.5f});
  const float there = Microfacet(LayerBlend::Layered, brushed, a).value(b).x / b.z;
  const float back = Microfacet(LayerBlend::Layered, brushed, b).value(a).x / a.z;
  EXPECT_NEAR(there, back, 1e-4 * there);
}

TEST(Microfacet, WhiteMattIsLambert) {
  const Microfacet f(LayerBlend::Layered, {.albedo = {1, 1, 1}, .f0 = {}, .roughness = 1}, view_at(0.6f));
  EXPECT_NEAR(f.value({0, 0, 1}).x, 2 / kTurn, 1e-6);
  EXPECT_EQ(f.value({0, 0.1f, -0.99f}).x, 0);
  EXPECT_EQ(f.pdf({0, 0.1f, -0.99f}), 0);
}

TEST(Microfacet, DensityIntegratesToAtMostOneAndSamplesFollowIt) {
  for (const RelitMaterial& m : materials()) {
    if (m.roughness < 0.4f) continue;  // the quadrature is too coarse for its peak
    for (const float cosine : {0.3f, 0.9f}) {
      const Microfacet f(LayerBlend::Layered, m, view_at(cosine));
      const double density = over_hemisphere([&](const Vec3f& l) { return f.pdf(l); });
      EXPECT_LE(density, 1.005);
      EXPECT_GE(density, 0.6);  // what is missing goes below the horizon
      // Mean of value / pdf over samples = quadrature of value.
      const double exact = over_hemisphere([&](const Vec3f& l) { return f.value(l).y; });
      const SamplePoints points(5, 7);
      double sum = 0;
      const uint32_t n = 16384;
      for (uint32_t i = 0; i < n; ++i) {
        const Vec3f l = f.sample(points.point(2, i).x, points.point(1, i));
        EXPECT_NEAR(length(l), 1, 1e-3);
        if (l.z > 0) sum += double(f.value(l).y) / f.pdf(l) / n;
      }
      EXPECT_NEAR(sum, exact, 0.02 * exact + 1e-4) << "rough " << m.roughness << " ks " << m.specular << " cos " << cosine;
    }
  }
}

TEST(SamplePoints, FillTheSquareEvenlyInEveryPlane) {
  const SamplePoints points(1, 2);
  for (uint32_t plane = 0; plane < 4; ++plane) {
    std::vector<int> cell(64, 0), column(64, 0);
    for (uint32_t i = 0; i < 64; ++i) {
      const Vec2f p = points.point(plane, i);
      ++cell[size_t(p.x * 8) * 8 + size_t(p.y * 8)];
      ++column[size_t(p.x * 64)];
    }
    EXPECT_EQ(std::ranges::count(cell, 1), 64);
    EXPECT_EQ(std::ranges::count(column, 1), 64);
  }
  EXPECT_NE(points.point(0, 3).x, points.point(1, 3).x);
  EXPECT_NE(points.point(0, 3).x, SamplePoints(1, 3).point(0, 3).x);
}

}  // namespace
}  // namespace vitrine
