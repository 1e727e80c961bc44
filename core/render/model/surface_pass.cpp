#include "core/render/model/surface_pass.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/quantile.h"
#include "core/render/model/gbuffer.h"
#include "core/render/model/opened_scene.h"
#include "core/render/model/sheet_pass.h"

namespace vitrine {

namespace {

constexpr uint64_t kChoiceStream = 0x5f01;
constexpr uint32_t kTile = 8;  // pixels; Morton order inside a tile
constexpr size_t kSurfaceGrain = 512;

// De-interleaves bits 0, 2, 4 and 1, 3, 5 of a tile's Morton index.
constexpr uint32_t tile_x(uint32_t i) { return (i & 1) | (i >> 1 & 2) | (i >> 2 & 4); }
constexpr uint32_t tile_y(uint32_t i) { return tile_x(i >> 1); }

}  // namespace

void SurfacePass::select(const SplatScene& scene, Frame& frame) {
  const SurfaceOptions& options = frame.options.surface;
  const GBuffer g(frame);
  const bool reflects = scene.reflection.size() > 0, transmits = scene.transmittance.size() > 0 || !frame.sheets.empty();
  const auto inside = [&](std::span<const float> mask, uint32_t pixel) {
    return !mask.empty() && mask[pixel] > options.mask_threshold;
  };
  const auto width = static_cast<uint32_t>(g.width), height = static_cast<uint32_t>(g.height);
  bands_.resize((height + kTile - 1) / kTile);
  parallel_for(bands_.size(), 1, [&](size_t band) {
    auto& requests = bands_[band];
    requests.clear();
    const uint32_t top = static_cast<uint32_t>(band) * kTile;
    for (uint32_t left = 0; left < width; left += kTile)
      for (uint32_t i = 0; i < kTile * kTile; ++i) {
        const uint32_t x = left + tile_x(i), y = top + tile_y(i);
        if (x >= width || y >= height) continue;
        const uint32_t pixel = y * width + x;
        if (!(g.alpha[pixel] > options.min_alpha)) continue;
        const bool glass = inside(frame.transparent_mask, pixel);
        const LayersPresent layers{.reflection = reflects && (glass || g.specular[pixel] > float(kMinSpecular) ||
                                                              inside(frame.specular_mask, pixel) || frame.coats.shows(pixel)),
                                   .transmission = transmits && (glass || g.transmission[pixel] > float(kMinSpecular))};
        if ((layers.reflection || layers.transmission) && g.has_surface(pixel)) requests.push_back({pixel, layers});
      }
  });
  ShadedPixels& s = frame.shaded;
  for (const auto& band : bands_)
    for (const RayRequest& a : band) {
      s.pixels.push_back(a.pixel);
      s.requests.push_back(a.layers);
    }
}

void SurfacePass::forward(const SplatScene& scene, Frame& frame) {
  ShadedPixels& s = frame.shaded;
  s.clear();
  if (scene.reflection.size() + scene.transmittance.size() == 0 && frame.sheets.empty()) return;
  const SurfaceOptions& options = frame.options.surface;
  select(scene, frame);
  const size_t requesting = s.pixels.size();
  const size_t groups = options.ray_budget > 0 ? std::min(requesting, static_cast<size_t>(options.ray_budget)) : requesting;
  if (groups == 0) return;
  s.begin.resize(groups + 1);
  for (size_t i = 0; i <= groups; ++i) s.begin[i] = static_cast<uint32_t>(i * requesting / groups);
  s.chosen.resize(groups);
  s.rays.resize(groups);
  s.points.resize(groups);
  s.grad_points.assign(groups, {});
  const GBuffer g(frame);
  const uint64_t draw = mix64(mix64(frame.seed, kChoiceStream), frame.step);
  parallel_chunks(groups, kSurfaceGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const uint32_t size = s.begin[i + 1] - s.begin[i];
      s.chosen[i] = s.begin[i] + (size > 1 ? Rng(draw, i).below(size) : 0);
      const uint32_t pixel = s.chosen_pixel(i);
      s.rays[i] = g.ray(pixel);
      s.points[i] = surface_point(g.sums(pixel), s.rays[i]);
    }
  });
}

void SurfacePass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  const SurfaceOptions& options = frame.options.surface;
  ShadedPixels& s = frame.shaded;
  const size_t groups = s.groups();
  if (groups == 0) return;
  float longest = INFINITY;
  if (options.normal_gradient && options.normal_quantile < 1) {
    lengths_.clear();
    for (const SurfacePoint<float>& p : s.grad_points)
      if (const float l = length(p.normal); l > 0) lengths_.push_back(l);
    if (!lengths_.empty()) longest = quantile_of(lengths_, options.normal_quantile);
  }
  const GBuffer g(frame);
  RasterImages& out = frame.grad_diffuse;
  const size_t pixels = frame.pixel_count();
  parallel_chunks(groups, kSurfaceGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      SurfacePoint<float> grad = s.grad_points[i];
      if (!options.normal_gradient) {
        grad.normal = {};
        grad.cosine = grad.agreement = 0;
      }
      if (!options.depth_gradient) grad.position = {};
      if (const float l = length(grad.normal); l > longest) grad.normal *= longest / l;
      const uint32_t pixel = s.chosen_pixel(i);
      if (frame.coats.shows(pixel)) grad = {.roughness = grad.roughness};
      const PixelSums<float> sums = surface_point_vjp(g.sums(pixel), s.rays[i], grad);
      for (size_t c = 0; c < 3; ++c) {
        out.plane(Aov::Normal)[c * pixels + pixel] += sums.normal[c];
        out.plane(Aov::F0)[c * pixels + pixel] += sums.f0[c];
      }
      out.plane(Aov::Roughness)[pixel] += sums.roughness;
      out.plane(Aov::ZDepth)[pixel] += sums.zdepth;
      out.plane(Aov::Alpha)[pixel] += sums.alpha;
    }
  });
}

namespace {
constexpr size_t kDiffuseGrain = 1 << 15;  // floats per parallel chunk
}

void DiffusePass::forward(const SplatScene& scene, Frame& frame) {
  const DiffuseOptions& options = frame.options.diffuse;
  RasterDesc desc;
  desc.intrinsics = frame.view->intrinsics;
  desc.cam_from_world = frame.view->cam_from_world;
  opened_ = draws_sheets(frame.options);
  const bool layered = scene.reflection.size() + scene.transmittance.size() > 0 || opened_;
  desc.features = layered || options.materials ? FeatureSet::Material : FeatureSet::Surface;
  frame.opened.clear();
  if (opened_) without_glass_with_materials(scene, opened_degrees(scene, frame.options), frame.opened);
  const SplatLayer& drawn = opened_ ? frame.opened.surfels : scene.diffuse;
  desc.sh_degree = opened_ ? drawn.sh_degree() : std::min(options.sh_degree, drawn.sh_degree());
  desc.distortion = options.distortion;
  desc.near_z = options.near_z;
  renderer_->forward(drawn, desc, frame.diffuse);
  const auto color = frame.diffuse.plane(Aov::Color);
  frame.linear.resize(color.size());
  parallel_chunks(color.size(), kDiffuseGrain, [&](size_t, size_t begin, size_t end) {
    std::copy(color.data() + begin, color.data() + end, frame.linear.data() + begin);
  });
  frame.grad_diffuse.reset(desc);
}

void DiffusePass::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  const auto grad_color = frame.grad_diffuse.plane(Aov::Color);
  parallel_chunks(grad_color.size(), kDiffuseGrain, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) grad_color[i] += frame.grad_linear[i];
  });
  if (opened_) return backward_of_opened(scene, frame, grad);
  renderer_->backward({.gradients = &frame.grad_diffuse, .error_image = frame.error_image}, grad.diffuse, &frame.statistics);
}

void DiffusePass::backward_of_opened(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  const SplatLayer& drawn = frame.opened.surfels;
  if (grad_.size() != drawn.size() || grad_.sh_degree() != drawn.sh_degree())
    grad_ = drawn.zeros_like();
  else
    grad_.fill(0.f);
  statistics_.reset(drawn.size());
  renderer_->backward({.gradients = &frame.grad_diffuse, .error_image = frame.error_image}, grad_, &statistics_);
  give_back(opened_degrees(scene, frame.options), {grad_, statistics_}, frame, grad);
}

}  // namespace vitrine
