// The passes against a specification: one pixel written down with the kernels and the reference tracer in dual numbers.
#include <gtest/gtest.h>

#include "core/foundation/math/dual.h"
#include "core/render/model/composite_pass.h"
#include "core/render/model/gbuffer.h"
#include "core/render/model/layered_model.h"
#include "core/render/model/pane_pass.h"
#include "core/render/model/shape_pass.h"
#include "core/render/model/sheet_pass.h"
#include "core/render/model/surface_pass.h"
#include "core/render/model/thin_glass_pass.h"
#include "core/render/model/traced_passes.h"
#include "core/render/trace/reference/reference_trace.h"
#include "tests/core/render/model/tiny_rooms.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

constexpr size_t kVariables = 14;
using N = Dual<double, kVariables>;

Vec3<N> constant(const Vec3d& v) { return {N(v.x), N(v.y), N(v.z)}; }
Vec3<N> variable(const Vec3d& v, size_t at) { return {N::variable(v.x, at), N::variable(v.y, at + 1), N::variable(v.z, at + 2)}; }

std::vector<reference::TraceSurfel<N>> surfels(const SplatLayer& layer) {
  std::vector<reference::TraceSurfel<N>> out;
  for (size_t i = 0; i < layer.size(); ++i) {
    reference::SurfelValues<N> values{};
    reference::visit_values(layer, values, [&](N& v, Attribute a, size_t c) { v = N(double(layer.at(a, i)[c])); });
    out.push_back(reference::trace_surfel(values));
  }
  return out;
}

struct PixelGrad {
  std::array<double, kVariables> d;  // normal, f0, roughness, zdepth, alpha, k_s, tau, C_d
};

// d (g . linear) / d channels of the chosen pixel of a group that is this pixel alone.
PixelGrad specified(const LayeredRoom& room, const ImageOptions& options, const Frame& frame, size_t group, const Vec3d& g) {
  const uint32_t pixel = frame.shaded.chosen_pixel(group);
  const GBuffer buffer(frame);
  const PixelSums<float> f = buffer.sums(pixel);
  const PixelSums<N> sums{variable(cast<double>(f.normal), 0), variable(cast<double>(f.f0), 3),
                          N::variable(double(f.roughness), 6), N::variable(double(f.zdepth), 7), N::variable(double(f.alpha), 8)};
  const N specular = N::variable(double(buffer.specular[pixel]), 9), tau = N::variable(double(buffer.transmission[pixel]), 10);
  const Vec3<N> diffuse = variable(cast<double>(buffer.rgb(buffer.color, pixel)), 11);
  const PixelRay<float> r = buffer.ray(pixel);
  const PixelRay<N> ray{constant(cast<double>(r.eye)), constant(cast<double>(r.direction_per_z)), constant(cast<double>(r.view))};
  const SurfacePoint<N> p = surface_point(sums, ray);

  const reference::MarchDesc<N> march{1, N(double(options.reflection.min_transmittance)), N(0.1)};
  std::vector<reference::BlendedHit<N>> hits;
  const auto mirror_layer = surfels(room.scene.reflection), glass_layer = surfels(room.scene.transmittance);
  Vec3<N> reflected_radiance{}, transmitted{};
  for (uint32_t i = frame.reflection.begin[group]; i < frame.reflection.begin[group + 1]; ++i) {
    const SecondaryRay& sent = frame.reflection.rays[i];
    Vec3<N> direction = reflected(ray.view, p.normal);
    N weight(1);
    if (options.reflection.lobe == Lobe::Sampled) {
      Vec3<double> n{p.normal.x.v, p.normal.y.v, p.normal.z.v};
      const Vec3<double> half = normalized(cast<double>(sent.lobe.half));
      const double r0 = p.roughness.v, density = ggx_distribution(r0 * r0, dot(n, half)).value;
      const auto lobe = glossy_ray(ray.view, p.normal, carried(constant(half), constant(n), p.normal), p.roughness, N(density));
      direction = lobe.direction;
      weight = lobe.weight;
    }
    const TraceRay<N> traced{p.position, direction, N(double(options.reflection.near)), N(1e30)};
    reflected_radiance += (N(double(sent.share)) * weight) * reference::trace_ray(mirror_layer, traced, march, hits).color;
  }
  const Vec3<N> fixed{N(p.position.x.v), N(p.position.y.v), N(p.position.z.v)};
  const TraceRay<N> straight{fixed, -ray.view, N(double(options.transmission.near)), N(1e30)};
  transmitted = reference::trace_ray(glass_layer, straight, march, hits).color;

  const auto w =
      layer_weights(options.composite.blend, BlendMaterial<N>{p.f0, specular, tau, p.cosine, p.agreement}, {true, true});
  const N value = dot(constant(g), hadamard(w.diffuse, diffuse) + hadamard(w.reflection, reflected_radiance) +
                                       hadamard(w.transmission, transmitted));
  return {value.d};
}

class LayeredChain : public testing::TestWithParam<std::tuple<LayerBlend, Lobe, TracerBackend>> {};

TEST_P(LayeredChain, ChannelGradientsAreThoseOfTheSpecification) {
  ImageOptions options;
  options.diffuse.backend = Backend::Reference;
  options.surface.normal_quantile = 1;
  options.composite.gate = 0;
  std::tie(options.composite.blend, options.reflection.lobe, options.reflection.backend) = GetParam();
  options.transmission.backend = options.reflection.backend;
  options.reflection.samples = options.reflection.lobe == Lobe::Sampled ? 3 : 1;
  const LayeredRoom room = furnished_room({}, 3);
  // A loss that is linear in the radiance: there is no display.
  ImageModel model(options);
  model.emplace<DiffusePass>(options.diffuse.backend);
  model.emplace<ShapePass>();
  model.emplace<SheetPass>();
  model.emplace<SurfacePass>();
  model.emplace<ThinGlassPass>(options.diffuse.backend);
  model.emplace<PanePass>(options.diffuse.backend);
  model.emplace<ReflectionPass>(options.reflection.backend);
  model.emplace<TransmissionPass>(options.transmission.backend);
  model.emplace<CompositePass>();
  Frame frame;
  model.forward(room.scene, room.view, frame);
  ASSERT_EQ(frame.shaded.groups(), frame.pixel_count());

  Rng rng(9);
  const size_t pixels = frame.pixel_count();
  frame.grad_linear.resize(3 * pixels);
  for (float& g : frame.grad_linear) g = rng.normal();
  const std::vector<float> g = frame.grad_linear;
  SplatScene grad = room.scene.zeros_like();
  model.backward(room.scene, frame, grad);

  struct Channel {
    const char* name;
    Aov aov;
    size_t at;
  };
  const Channel channels[] = {{"normal", Aov::Normal, 0},
                              {"f0", Aov::F0, 3},
                              {"roughness", Aov::Roughness, 6},
                              {"zdepth", Aov::ZDepth, 7},
                              {"alpha", Aov::Alpha, 8},
                              {"specular", Aov::SpecularWeight, 9},
                              {"transmission", Aov::Transmission, 10},
                              {"color", Aov::Color, 11}};
  std::vector<PixelGrad> exact;
  for (size_t i = 0; i < frame.shaded.groups(); ++i) {
    const uint32_t p = frame.shaded.chosen_pixel(i);
    exact.push_back(specified(room, options, frame, i, {double(g[p]), double(g[pixels + p]), double(g[2 * pixels + p])}));
  }
  for (const Channel& c : channels) {
    std::vector<double> expected;
    std::vector<float> actual;
    const auto width = size_t(row(c.aov).width);
    for (size_t i = 0; i < frame.shaded.groups(); ++i)
      for (size_t k = 0; k < width; ++k) {
        expected.push_back(exact[i].d[c.at + k]);
        actual.push_back(frame.grad_diffuse.plane(c.aov)[k * pixels + frame.shaded.chosen_pixel(i)]);
      }
    if (c.aov == Aov::Roughness && options.reflection.lobe == Lobe::Mirror) {
      for (float v : actual) EXPECT_EQ(v, 0);
      continue;
    }
    // Worst seen: 1.1e-5 (roughness of sampled rays).
    expect_grad_close(actual, expected, {.relative_l2 = 5e-5, .bias = 5e-5}, c.name);
  }
}

INSTANTIATE_TEST_SUITE_P(All, LayeredChain,
                         testing::Combine(testing::Values(LayerBlend::RtrGs, LayerBlend::Layered),
                                          testing::Values(Lobe::Mirror, Lobe::Sampled),
                                          testing::Values(TracerBackend::Embree, TracerBackend::Blocks)));

}  // namespace
}  // namespace vitrine
