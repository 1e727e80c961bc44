// Every kernel of the shading against dual numbers pushed through its own forward function, in double.
#include <gtest/gtest.h>

#include <array>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/dual.h"
#include "core/render/model/kernels/ggx.h"
#include "core/render/model/kernels/layer_blend.h"
#include "core/render/model/kernels/mirror.h"
#include "core/render/model/kernels/surface_point.h"

namespace vitrine {
namespace {

constexpr double kTolerance = 1e-9;  // worst seen: 3e-13

template <size_t N>
using D = Dual<double, N>;

struct Draw {
  Rng rng;
  explicit Draw(uint64_t seed) : rng(seed, 5) {}
  double unit() { return rng.uniform_double(); }
  double signed_unit() { return 2 * unit() - 1; }
  Vec3d vec() { return {signed_unit(), signed_unit(), signed_unit()}; }
  Vec3d color() { return {unit(), unit(), unit()}; }
  // Within a cone around n.
  Vec3d around(const Vec3d& n, double spread) { return normalized(n + spread * vec()); }
};

template <size_t N>
Vec3<D<N>> variables(const Vec3d& v, size_t at) {
  return {D<N>::variable(v.x, at), D<N>::variable(v.y, at + 1), D<N>::variable(v.z, at + 2)};
}
template <size_t N>
Vec3<D<N>> constants(const Vec3d& v) {
  return {D<N>(v.x), D<N>(v.y), D<N>(v.z)};
}

TEST(Fresnel, MatchesDualNumbersAndIsOneAtGrazing) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Draw draw(seed);
    const Vec3d f0 = draw.color(), g = draw.vec();
    const double c = draw.unit();
    const auto exact = dot(schlick(variables<4>(f0, 0), D<4>::variable(c, 3)).value, constants<4>(g));
    Vec3d grad_f0{};
    double grad_c = 0, grad_clear = 0;
    fresnel_vjp(f0, schlick(f0, c), g, grad_f0, grad_c, grad_clear);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(grad_f0[i], exact.d[i], kTolerance);
    EXPECT_NEAR(grad_c, exact.d[3], kTolerance);
  }
  const Vec3d f0{0.04, 0.5, 0.9};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(schlick(f0, 1.0).value[i], f0[i]);
    EXPECT_EQ(schlick(f0, 0.0).value[i], 1.0);
    EXPECT_EQ(schlick(f0, -0.2).value[i], 1.0);
  }
}

// Both sides of a pane of index 1.5, light going to and fro between them, summed up term by term from Fresnel's amplitudes.
TEST(Fresnel, ClearSheetsReflectAtBothSides) {
  const Vec3d f0{kPaneReflectance, kPaneReflectance, kPaneReflectance};
  for (double angle_deg : {0.0, 30.0, 56.3, 61.0, 77.0, 89.0}) {
    const double i = angle_deg * std::numbers::pi / 180, t = std::asin(std::sin(i) / 1.5);
    double sheet = 0;
    for (bool parallel : {false, true}) {
      const double r = parallel ? (std::cos(t) - 1.5 * std::cos(i)) / (std::cos(t) + 1.5 * std::cos(i))
                                : (std::cos(i) - 1.5 * std::cos(t)) / (std::cos(i) + 1.5 * std::cos(t));
      sheet += 0.5 * r * r;
    }
    double sum = sheet, inside = (1 - sheet) * (1 - sheet) * sheet;
    for (int bounce = 0; bounce < 200; ++bounce) sum += inside, inside *= sheet * sheet;
    EXPECT_NEAR(fresnel(f0, std::cos(i), 1.0).value.x, sum, 1e-9) << angle_deg;
  }
  EXPECT_NEAR(fresnel(f0, std::cos(61 * std::numbers::pi / 180), 1.0).value.x, 0.17, 0.005);
  EXPECT_NEAR(schlick(f0, std::cos(61 * std::numbers::pi / 180)).value.x, 0.11, 0.005);
  EXPECT_EQ(fresnel(f0, 1.0, 1.0).value.x, f0.x);
  EXPECT_EQ(fresnel(f0, -0.1, 1.0).value.x, 1.0);
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Draw draw(seed);
    const Vec3d any = draw.color(), g = draw.vec();
    const double c = draw.unit(), clear = draw.unit();
    const auto exact = dot(fresnel(variables<5>(any, 0), D<5>::variable(c, 3), D<5>::variable(clear, 4)).value, constants<5>(g));
    Vec3d grad_f0{};
    double grad_c = 0, grad_clear = 0;
    fresnel_vjp(any, fresnel(any, c, clear), g, grad_f0, grad_c, grad_clear);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(grad_f0[i], exact.d[i], kTolerance);
    EXPECT_NEAR(grad_c, exact.d[3], kTolerance);
    EXPECT_NEAR(grad_clear, exact.d[4], kTolerance);
  }
}

// One wall of a block: the same amplitudes without the second wall, from outside and from inside.
TEST(Fresnel, OneWallOfSolidGlassReflectsLessThanASheet) {
  const Vec3d f0{kWallReflectance, kWallReflectance, kWallReflectance};
  for (const double angle_deg : {0.0, 30.0, 56.3, 77.0, 89.0}) {
    const double i = angle_deg * std::numbers::pi / 180, t = std::asin(std::sin(i) / kGlassIndex);
    const double outside = dielectric_reflectance(std::cos(i), 1 / kGlassIndex);
    EXPECT_NEAR(fresnel(f0, std::cos(i), 1.0, true).value.x, outside, 1e-9) << angle_deg;
    EXPECT_NEAR(dielectric_reflectance(std::cos(t), kGlassIndex), outside, 1e-9) << angle_deg;
    EXPECT_NEAR(2 * outside / (1 + outside),
                fresnel({kPaneReflectance, kPaneReflectance, kPaneReflectance}, std::cos(i), 1.0).value.x, 1e-9);
  }
  EXPECT_NEAR(fresnel(f0, 1.0, 1.0, true).value.x, 0.04, 1e-12);
  EXPECT_EQ(dielectric_reflectance(std::cos(0.8), kGlassIndex), 1) << "total reflection";
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Draw draw(seed);
    const Vec3d any = draw.color(), g = draw.vec();
    const double c = draw.unit(), clear = draw.unit();
    const auto exact =
        dot(fresnel(variables<5>(any, 0), D<5>::variable(c, 3), D<5>::variable(clear, 4), true).value, constants<5>(g));
    Vec3d grad_f0{};
    double grad_c = 0, grad_clear = 0;
    fresnel_vjp(any, fresnel(any, c, clear, true), g, grad_f0, grad_c, grad_clear);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(grad_f0[i], exact.d[i], kTolerance);
    EXPECT_NEAR(grad_c, exact.d[3], kTolerance);
    EXPECT_NEAR(grad_clear, exact.d[4], kTolerance);
  }
}

TEST(Ggx, DistributionAndShadowingMatchDualNumbers) {
  for (double alpha : {0.002, 0.04, 0.3, 0.9})
    for (double x : {0.3, 0.8, 0.999}) {
      const auto d = ggx_distribution(D<1>::variable(alpha, 0), D<1>(x)).value;
      EXPECT_NEAR(ggx_distribution(alpha, x).slope_alpha, d.d[0], kTolerance * std::abs(d.d[0]));
    }
}

// integral of D n.h over the hemisphere of half vectors is one.
TEST(Ggx, DistributionOfProjectedMicrofacetsIsNormalised) {
  for (double alpha : {0.05, 0.3, 1.0}) {
    double sum = 0;
    constexpr int kSteps = 200000;
    for (int i = 0; i < kSteps; ++i) {
      const double x = (i + 0.5) / kSteps;
      sum += ggx_distribution(alpha, x).value * x * 2 * std::numbers::pi / kSteps;
    }
    EXPECT_NEAR(sum, 1, 1e-3) << alpha;
  }
}

TEST(Ggx, HalfVectorsHaveTheDensityOfTheDistribution) {
  const Vec3d n = normalized(Vec3d{0.3, -0.5, -0.6});
  const double alpha = 0.4;
  constexpr int kBins = 8, kSamples = 200000;
  std::array<int, kBins> counts{};
  Draw draw(3);
  for (int i = 0; i < kSamples; ++i) {
    const Vec3d h = ggx_half_vector(n, alpha, draw.unit(), draw.unit());
    EXPECT_NEAR(length(h), 1, 1e-12);
    const double x = dot(n, h);
    ASSERT_GE(x, -1e-12);
    ++counts[std::min(size_t(x * kBins), size_t(kBins - 1))];
  }
  for (int b = 0; b < kBins; ++b) {
    double expected = 0;
    for (int i = 0; i < 1000; ++i) {
      const double x = (b + (i + 0.5) / 1000) / kBins;
      expected += ggx_distribution(alpha, x).value * x * 2 * std::numbers::pi / (1000.0 * kBins);
    }
    EXPECT_NEAR(counts[size_t(b)] / double(kSamples), expected, 5 * std::sqrt(expected / kSamples) + 1e-5) << b;
  }
}

// E[W] against the integral of D G/(4 n.v) over the hemisphere of directions.
TEST(Ggx, SampledWeightAveragesToTheDirectionalAlbedo) {
  const Vec3d n{0, 0, 1};
  const double roughness = 0.5, alpha = roughness * roughness, k = alpha / 2;
  const Vec3d v{std::sqrt(1 - 0.49), 0, 0.7};
  double quadrature = 0;
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double z = (i + 0.5) / kSteps, phi = 2 * std::numbers::pi * (j + 0.5) / kSteps, s = std::sqrt(1 - z * z);
      const Vec3d l{s * std::cos(phi), s * std::sin(phi), z};
      quadrature += ggx_distribution(alpha, normalized(l + v).z).value * smith_g1(0.7, k) * smith_g1(z, k) / (4 * 0.7);
    }
  quadrature *= 2 * std::numbers::pi / (kSteps * kSteps);
  Draw draw(8);
  double sum = 0;
  constexpr int kSamples = 100000;
  for (int i = 0; i < kSamples; ++i)
    sum += glossy_ray(v, n, ggx_half_vector(n, alpha, draw.unit(), draw.unit()), roughness).weight;
  EXPECT_NEAR(sum / kSamples, quadrature, 3e-3);
  EXPECT_NEAR(quadrature, 0.8147, 1e-3);
}

TEST(Mirror, HalfVectorIsCarriedByTheSmallestRotation) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    Draw draw(seed);
    const Vec3d a = normalized(draw.vec()), b = draw.around(a, 0.7), h = draw.around(a, 0.5);
    const Vec3d moved = carried(h, a, b), same = carried(a, a, b);
    EXPECT_NEAR(length(moved), 1, 1e-12);
    EXPECT_NEAR(dot(moved, b), dot(h, a), 1e-12);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(same[c], b[c], 1e-12);
  }
}

// The whole sampled ray: the half vector travels with the normal, D0 is a constant.
TEST(GlossyRay, GradientMatchesDualNumbersWithTheSampleHeldInTheFrame) {
  int alive = 0;
  for (uint64_t seed = 0; seed < 60; ++seed) {
    Draw draw(seed);
    const Vec3d n = normalized(draw.vec()), v = draw.around(n, 0.9), g = draw.vec();
    const double roughness = 0.2 + 0.7 * draw.unit(), gw = draw.signed_unit();
    const Vec3d h = ggx_half_vector(n, roughness * roughness, draw.unit(), draw.unit());
    const GlossyRay<double> ray = glossy_ray(v, n, h, roughness);
    if (!(ray.weight > 0)) continue;
    ++alive;
    const auto normal = normalized(variables<4>(n, 0));
    const auto r = D<4>::variable(roughness, 3);
    const auto half = carried(constants<4>(h), constants<4>(n), normal);
    const double density = ggx_distribution(roughness * roughness, dot(n, h)).value;
    const auto exact_ray = glossy_ray(constants<4>(v), normal, half, r, D<4>(density));
    EXPECT_NEAR(exact_ray.weight.v, ray.weight, 1e-9 * ray.weight);
    const auto exact = dot(exact_ray.direction, constants<4>(g)) + D<4>(gw) * exact_ray.weight;
    const GlossyGrad<double> actual = glossy_ray_vjp(v, n, roughness, ray, g, gw);
    const Vec3d on_sphere = normalized_vjp(n, actual.normal);
    for (size_t i = 0; i < 3; ++i) EXPECT_NEAR(on_sphere[i], exact.d[i], 1e-8 * (1 + std::abs(exact.d[i]))) << seed;
    EXPECT_NEAR(actual.roughness, exact.d[3], 1e-8 * (1 + std::abs(exact.d[3]))) << seed;
  }
  EXPECT_GT(alive, 40);
}

// With the half vector on the normal the sampled ray is the mirror ray.
TEST(GlossyRay, BecomesTheMirrorForSmoothSurfaces) {
  const Vec3d n = normalized(Vec3d{0.2, 0.9, -0.1}), v = normalized(Vec3d{0.5, 0.6, 0.3});
  const GlossyRay<double> ray = glossy_ray(v, n, n, 0.03);
  EXPECT_NEAR(ray.weight, 1, 1e-3);
  const Vec3d w = 2 * dot(v, n) * n - v;
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(ray.direction[c], w[c], 1e-15);
}

class Blend : public testing::TestWithParam<std::tuple<LayerBlend, bool, bool>> {};

TEST_P(Blend, MatchesDualNumbers) {
  const auto [blend, reflection, transmission] = GetParam();
  const LayersPresent present{reflection, transmission};
  for (uint64_t seed = 0; seed < 40; ++seed) {
    Draw draw(seed);
    BlendMaterial<double> m{draw.color(),
                            seed % 3 == 0   ? 0.05 * draw.unit()
                            : seed % 5 == 0 ? 0.001 * draw.unit()
                                            : draw.unit(),
                            draw.unit(), draw.unit(), draw.unit()};
    const LayerWeights<double> g{draw.vec(), draw.vec(), draw.vec()};
    m.coat = seed % 4 == 3;
    BlendMaterial<D<7>> dual{variables<7>(m.f0, 0), D<7>::variable(m.specular, 3), D<7>::variable(m.transmission, 4),
                             D<7>::variable(m.cosine, 5), D<7>::variable(m.agreement, 6)};
    dual.coat = m.coat;
    const auto w = layer_weights(blend, dual, present);
    const auto exact = dot(w.diffuse, constants<7>(g.diffuse)) + dot(w.reflection, constants<7>(g.reflection)) +
                       dot(w.transmission, constants<7>(g.transmission));
    const BlendMaterial<double> actual = layer_weights_vjp(blend, m, present, g);
    const double got[] = {actual.f0.x,         actual.f0.y,   actual.f0.z,     actual.specular,
                          actual.transmission, actual.cosine, actual.agreement};
    for (size_t i = 0; i < 7; ++i) EXPECT_NEAR(got[i], exact.d[i], kTolerance * (1 + std::abs(exact.d[i]))) << seed << " " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Blend,
                         testing::Combine(testing::Values(LayerBlend::RtrGs, LayerBlend::Layered), testing::Bool(),
                                          testing::Bool()));

TEST(LayerBlend, WeightsNeverAmplify) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    Draw draw(seed);
    const BlendMaterial<double> m{draw.color(), draw.unit(), draw.unit(), draw.unit()};
    for (LayerBlend blend : {LayerBlend::RtrGs, LayerBlend::Layered}) {
      const LayerWeights<double> w = layer_weights(blend, m, {true, true});
      for (size_t c = 0; c < 3; ++c) {
        EXPECT_LE(w.diffuse[c] + w.reflection[c] + w.transmission[c], 1 + 1e-12);
        EXPECT_GE(std::min({w.diffuse[c], w.reflection[c], w.transmission[c]}), 0);
      }
    }
  }
}

TEST(LayerBlend, ACoatReflectsByFresnelsLawWithoutSpecularWeight) {
  BlendMaterial<double> coat{{0.04, 0.04, 0.04}, 0, 0, 0.3};
  coat.coat = true;
  const LayerWeights<double> w = layer_weights(LayerBlend::Layered, coat, {true, true});
  EXPECT_NEAR(w.reflection.x, 0.04 + 0.96 * std::pow(0.7, 5), 1e-12);
  EXPECT_NEAR(w.diffuse.x + w.reflection.x, 1, 1e-12);
  const BlendMaterial<double> grad = layer_weights_vjp(LayerBlend::Layered, coat, {true, true}, {.reflection = {1, 0, 0}});
  EXPECT_GT(grad.specular, 0.5) << "it can grow from nothing";
}

// What the text of the issue asks of the layered blend: an opaque pixel without specular weight keeps its colour, at any angle,
// and the picture has no step where rays begin.
TEST(LayerBlend, PixelsWithoutSpecularWeightAreDiffuse) {
  for (double cosine : {0.01, 0.3, 1.0})
    for (LayerBlend blend : {LayerBlend::RtrGs, LayerBlend::Layered}) {
      const LayerWeights<double> w = layer_weights(blend, BlendMaterial<double>{{0.5, 0.5, 0.5}, 0, 0, cosine}, {true, true});
      EXPECT_EQ(w.diffuse.x, 1);
      EXPECT_EQ(w.reflection.x, 0);
      EXPECT_EQ(w.transmission.x, 0);
      const LayerWeights<double> edge =
          layer_weights(blend, BlendMaterial<double>{{0.5, 0.5, 0.5}, kMinSpecular, 0, cosine}, {true, true});
      EXPECT_GE(edge.diffuse.x, 1 - kMinSpecular - 1e-12);
    }
}

// A glass pane: weights are the physical ones in both blends (k_s = 1, and hardly any k_s, respectively).
TEST(LayerBlend, BothFormsHoldGlassAndMetal) {
  const double cosine = 0.4, F = fresnel(Vec3d{0.04, 0.04, 0.04}, cosine, 1.0).value.x;
  const LayerWeights<double> m2 =
      layer_weights(LayerBlend::RtrGs, BlendMaterial<double>{{0.04, 0.04, 0.04}, 1.0, 1.0, cosine}, {true, true});
  EXPECT_NEAR(m2.reflection.x, F, 1e-12);
  EXPECT_NEAR(m2.transmission.x, 1 - F, 1e-12);
  const LayerWeights<double> m3 =
      layer_weights(LayerBlend::Layered, BlendMaterial<double>{{0.04, 0.04, 0.04}, 0.002, 1.0, cosine}, {true, true});
  EXPECT_NEAR(m3.reflection.x, F + 0.002 * (1 - F), 1e-12);
  EXPECT_NEAR(m3.reflection.x + m3.transmission.x, 1, 1e-12);
  const LayerWeights<double> metal =
      layer_weights(LayerBlend::RtrGs, BlendMaterial<double>{{0.9, 0.8, 0.7}, 1.0, 0.0, 1.0}, {true, true});
  EXPECT_NEAR(metal.reflection.y, 0.8, 1e-12);
}

TEST(SurfacePoint, MatchesDualNumbers) {
  for (uint64_t seed = 0; seed < 30; ++seed) {
    Draw draw(seed);
    const Vec3d direction = draw.vec();
    const PixelRay<double> ray{draw.vec(), direction, -1.0 * normalized(direction)};
    const double alpha = 0.5 + 0.5 * draw.unit();
    const PixelSums<double> s{alpha * draw.unit() * normalized(draw.vec()), alpha * draw.color(),
                              (seed % 4 == 0   ? 0.01
                               : seed % 4 == 1 ? 1.3
                                               : draw.unit()) *
                                  alpha,
                              2 * alpha * draw.unit(), alpha};
    const SurfacePoint<double> g{draw.vec(), draw.vec(), draw.vec(), draw.signed_unit(), draw.signed_unit(), draw.signed_unit()};
    using N = D<9>;
    const PixelSums<N> dual{variables<9>(s.normal, 0), variables<9>(s.f0, 3), N::variable(s.roughness, 6),
                            N::variable(s.zdepth, 7), N::variable(s.alpha, 8)};
    const auto p =
        surface_point(dual, PixelRay<N>{constants<9>(ray.eye), constants<9>(ray.direction_per_z), constants<9>(ray.view)});
    const auto exact = dot(p.position, constants<9>(g.position)) + dot(p.normal, constants<9>(g.normal)) +
                       dot(p.f0, constants<9>(g.f0)) + p.roughness * N(g.roughness) + p.cosine * N(g.cosine) +
                       p.agreement * N(g.agreement);
    const PixelSums<double> a = surface_point_vjp(s, ray, g);
    const double got[] = {a.normal.x, a.normal.y, a.normal.z, a.f0.x, a.f0.y, a.f0.z, a.roughness, a.zdepth, a.alpha};
    for (size_t i = 0; i < 9; ++i) EXPECT_NEAR(got[i], exact.d[i], kTolerance * (1 + std::abs(exact.d[i]))) << seed << " " << i;
  }
}

// A pixel half of a kettle's rim and half of the wall behind it: their mean normal looks at neither, and nothing is mirrored.
TEST(SurfacePoint, MirrorsWhereNormalsOfThePixelAgree) {
  const auto agreement = [](double angle_deg, double alpha) {
    const double half = angle_deg / 2 * std::numbers::pi / 180;
    const Vec3d a{std::sin(half), 0, std::cos(half)}, b{-std::sin(half), 0, std::cos(half)};
    return normal_agreement(0.5 * alpha * (a + b), alpha);
  };
  for (double alpha : {0.6, 1.0}) {
    EXPECT_EQ(agreement(0, alpha), 1);
    EXPECT_EQ(agreement(72, alpha), 1) << "a rounded thing";
    EXPECT_EQ(agreement(121, alpha), 0);
    EXPECT_GT(agreement(80, alpha), agreement(100, alpha));
    EXPECT_NEAR(agreement(98.86, alpha), 0.5, 0.01);
  }
  for (LayerBlend blend : {LayerBlend::RtrGs, LayerBlend::Layered}) {
    const LayerWeights<double> w = layer_weights(blend, BlendMaterial<double>{{0.9, 0.8, 0.7}, 0.8, 0, 0.1, 0}, {true, false});
    EXPECT_EQ(w.diffuse.x, 1);
    EXPECT_EQ(w.reflection.x, 0);
  }
}

}  // namespace
}  // namespace vitrine
