#include "core/render/model/composite_pass.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/render/model/gbuffer.h"
#include "core/render/model/kernels/pane_blend.h"

namespace vitrine {

namespace {

constexpr size_t kCompositeGrain = 512;  // groups per parallel chunk
constexpr size_t kPixels = 1 << 14;

float mean(const Vec3f& v) { return (v.x + v.y + v.z) / 3.f; }

// Layers available in a pixel: those it requested, if the group's rays sampled them.
LayersPresent present(const Frame& frame, size_t group, uint32_t entry) {
  const LayersPresent requested = frame.shaded.requests[entry], sent = frame.shaded.requested(group);
  return {.reflection = requested.reflection && sent.reflection,
          .transmission = requested.transmission && (sent.transmission || !frame.behind.radiance.empty())};
}

Vec3f radiance(const SecondaryRays& rays, size_t group) { return rays.radiance.empty() ? Vec3f{} : rays.radiance[group]; }

Vec3f at(const std::vector<float>& plane, size_t pixels, uint32_t pixel) {
  return {plane[pixel], plane[pixels + pixel], plane[2 * pixels + pixel]};
}

// Transmitted radiance: per pixel behind thin glass, otherwise per group.
Vec3f transmitted(const Frame& frame, size_t group, uint32_t pixel) {
  const std::vector<float>& own = frame.behind.radiance;
  return own.empty() ? radiance(frame.transmission, group) : at(own, frame.pixel_count(), pixel);
}

PaneView<float> pane_view(const Frame& frame, uint32_t pixel) {
  const PaneImages& p = frame.panes;
  if (p.empty() || !p.shown[pixel]) return {};
  const size_t pixels = frame.pixel_count();
  return {.near_color = at(p.near_color, pixels, pixel),
          .far_color = at(p.far_color, pixels, pixel),
          .near_open = p.near_open[pixel],
          .far_open = p.far_open[pixel],
          .far_share = p.far_share[pixel],
          .far_cosine = p.far_cosine[pixel]};
}

void write(std::vector<float>& plane, size_t pixels, uint32_t pixel, const Vec3f& v) {
  for (size_t c = 0; c < 3; ++c) plane[c * pixels + pixel] = v[c];
}

void start_layers(Frame& frame) {
  LayerImages& l = frame.layers;
  const size_t pixels = frame.pixel_count();
  l.diffuse = frame.linear;
  for (auto* plane : {&l.reflection, &l.transmission, &l.reflected, &l.transmitted, &l.fresnel}) plane->assign(3 * pixels, 0.f);
  l.inner_transmittance.assign(pixels, 1.f);
}

// Sizes the weights of each existing radiance.
void start_weights(Frame& frame) {
  for (SecondaryRays* rays : {&frame.reflection, &frame.transmission}) rays->picture_weight.assign(rays->radiance.size(), 0.f);
  frame.behind.picture_weight.assign(frame.behind.radiance.size() / 3, 0.f);
}

}  // namespace

void LayerImages::clear() {
  for (auto* plane : {&diffuse, &reflection, &transmission, &reflected, &transmitted, &fresnel, &inner_transmittance})
    plane->clear();
}

void CompositePass::forward(const SplatScene&, Frame& frame) {
  const ShadedPixels& s = frame.shaded;
  const size_t pixels = frame.pixel_count();
  frame.layers.clear();
  if (frame.options.composite.layer_images) start_layers(frame);
  start_weights(frame);
  if (s.groups() == 0) return;
  const bool gated = frame.options.composite.gate > 0 && !frame.reflection.radiance.empty() &&
                     (!frame.transmission.radiance.empty() || !frame.behind.radiance.empty());
  reflected_.resize(gated ? pixels : 0);
  parallel_chunks(reflected_.size(), kPixels,
                  [&](size_t, size_t begin, size_t end) { std::fill(reflected_.data() + begin, reflected_.data() + end, 0.f); });
  const GBuffer buffer(frame);
  parallel_chunks(s.groups(), kCompositeGrain, [&](size_t, size_t first, size_t last) {
    for (size_t g = first; g < last; ++g) {
      const Vec3f of_group = radiance(frame.reflection, g);
      for (uint32_t i = s.begin[g]; i < s.begin[g + 1]; ++i) {
        const uint32_t pixel = s.pixels[i];
        const BlendMaterial<float> material = buffer.material(pixel);
        const Vec3f straight = transmitted(frame, g, pixel);
        const auto [c_r, c_t] = behind_panes(pane_view(frame, pixel), material.f0, {of_group, straight});
        const LayersPresent shown = present(frame, g, i);
        const LayerWeights<float> w = layer_weights(frame.options.composite.blend, material, shown);
        const Vec3f diffuse = hadamard(w.diffuse, buffer.rgb(buffer.color, pixel));
        const Vec3f reflection = hadamard(w.reflection, c_r), transmission = hadamard(w.transmission, c_t);
        write(frame.linear, pixels, pixel, diffuse + reflection + transmission);
        if (gated) reflected_[pixel] = std::sqrt(std::max(0.f, mean(reflection)));
        if (i == s.chosen[g]) {
          if (!frame.reflection.picture_weight.empty()) frame.reflection.picture_weight[g] = mean(w.reflection);
          if (!frame.transmission.picture_weight.empty()) frame.transmission.picture_weight[g] = mean(w.transmission);
        }
        if (!frame.behind.picture_weight.empty()) frame.behind.picture_weight[pixel] = mean(w.transmission);
        if (!frame.options.composite.layer_images) continue;
        LayerImages& l = frame.layers;
        write(l.diffuse, pixels, pixel, diffuse);
        write(l.reflection, pixels, pixel, reflection);
        write(l.transmission, pixels, pixel, transmission);
        if (shown.reflection) {
          write(l.reflected, pixels, pixel, c_r);
          write(l.fresnel, pixels, pixel,
                fresnel(material.f0, material.cosine, shown.transmission ? material.transmission : 0.f, material.solid).value);
        }
        if (shown.transmission) {
          write(l.transmitted, pixels, pixel, straight);
          l.inner_transmittance[pixel] =
              frame.behind.radiance.empty() ? frame.transmission.inner_transmittance[g] : frame.behind.inner_transmittance[pixel];
        }
      }
    }
  });
}

float CompositePass::gate(const Frame& frame, uint32_t pixel) const {
  if (reflected_.empty()) return 1;
  const int width = frame.view->intrinsics.width, height = frame.view->intrinsics.height;
  const int x = static_cast<int>(pixel) % width, y = static_cast<int>(pixel) / width;
  float sum = 0, squares = 0, count = 0;
  for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
    for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
      const float value = reflected_[static_cast<size_t>(v * width + u)];
      sum += value;
      squares += value * value;
      ++count;
    }
  const float average = sum / count;
  return std::exp(-frame.options.composite.gate * std::max(0.f, squares / count - average * average));
}

// Gradient of the per-pixel transmitted radiance of all pixels of the group.
void CompositePass::behind_backward(Frame& frame, const GBuffer& buffer, size_t group) const {
  const ShadedPixels& s = frame.shaded;
  for (uint32_t i = s.begin[group]; i < s.begin[group + 1]; ++i) {
    const uint32_t pixel = s.pixels[i];
    const LayersPresent shown = present(frame, group, i);
    if (!shown.transmission) continue;
    const LayerWeights<float> w = layer_weights(frame.options.composite.blend, buffer.material(pixel), shown);
    Vec3f ignored{};
    const Vec3f grad = gate(frame, pixel) * hadamard(buffer.rgb(frame.grad_linear, pixel), w.transmission);
    write(frame.behind.grad_radiance, frame.pixel_count(), pixel,
          behind_panes_vjp(pane_view(frame, pixel), buffer.material(pixel).f0, {}, {{}, grad}, ignored).transmitted);
  }
}

// Gradient of the per-pixel reflection in flat mirrors.
void CompositePass::mirrors_backward(Frame& frame, const GBuffer& buffer, size_t group) const {
  const ShadedPixels& s = frame.shaded;
  const Vec3f beyond = radiance(frame.reflection, group);
  for (uint32_t i = s.begin[group]; i < s.begin[group + 1]; ++i) {
    const uint32_t pixel = s.pixels[i];
    if (!frame.panes.passes_gradient[pixel]) continue;
    const LayerWeights<float> w = layer_weights(frame.options.composite.blend, buffer.material(pixel), present(frame, group, i));
    const Vec3f grad = hadamard(buffer.rgb(frame.grad_linear, pixel), w.reflection);
    write(frame.panes.grad_near, frame.pixel_count(), pixel, grad);
    frame.panes.grad_open[pixel] = dot(grad, beyond);
    frame.panes.picture_weight[pixel] = mean(w.reflection);
  }
}

void CompositePass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  ShadedPixels& s = frame.shaded;
  if (s.groups() == 0) return;
  const GBuffer buffer(frame);
  const size_t pixels = frame.pixel_count();
  parallel_chunks(s.groups(), kCompositeGrain, [&](size_t, size_t first, size_t last) {
    for (size_t g = first; g < last; ++g) {
      const uint32_t pixel = s.chosen_pixel(g);
      const Vec3f grad = s.weight(g) * buffer.rgb(frame.grad_linear, pixel);
      if (!frame.behind.radiance.empty()) behind_backward(frame, buffer, g);
      if (!frame.panes.grad_near.empty()) mirrors_backward(frame, buffer, g);
      for (uint32_t i = s.begin[g]; i < s.begin[g + 1]; ++i) write(frame.grad_linear, pixels, s.pixels[i], {});

      const BlendMaterial<float> material = buffer.material(pixel);
      const LayersPresent shown = present(frame, g, s.chosen[g]);
      const LayerWeights<float> w = layer_weights(frame.options.composite.blend, material, shown);
      const PaneView<float> panes = pane_view(frame, pixel);
      const PaneRadiances<float> arrived{radiance(frame.reflection, g), transmitted(frame, g, pixel)};
      const auto [c_r, c_t] = behind_panes(panes, material.f0, arrived);
      BlendMaterial<float> grad_material = layer_weights_vjp(frame.options.composite.blend, material, shown,
                                                             {.diffuse = hadamard(grad, buffer.rgb(buffer.color, pixel)),
                                                              .reflection = hadamard(grad, c_r),
                                                              .transmission = hadamard(grad, c_t)});
      const PaneRadiances<float> grad_arrived = behind_panes_vjp(
          panes, material.f0, arrived, {hadamard(grad, w.reflection), hadamard(grad, w.transmission)}, grad_material.f0);
      SurfacePoint<float>& point = s.grad_points[g];
      point.f0 += grad_material.f0;
      point.cosine += grad_material.cosine;
      point.agreement += grad_material.agreement;
      frame.grad_diffuse.plane(Aov::SpecularWeight)[pixel] += grad_material.specular;
      frame.grad_diffuse.plane(Aov::Transmission)[pixel] += grad_material.transmission;
      if (shown.reflection && !frame.reflection.grad_radiance.empty()) frame.reflection.grad_radiance[g] = grad_arrived.reflected;
      if (shown.transmission && frame.behind.radiance.empty())
        frame.transmission.grad_radiance[g] = gate(frame, pixel) * grad_arrived.transmitted;
      write(frame.grad_linear, pixels, pixel, hadamard(grad, w.diffuse));
    }
  });
}

}  // namespace vitrine
