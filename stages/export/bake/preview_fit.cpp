#include "stages/export/bake/preview_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"
#include "core/render/picture/view_picture.h"
#include "core/render/raster/renderer.h"
#include "stages/export/formats/gaussian_ply.h"

namespace vitrine {

namespace {

constexpr double kUnseen = 1e-3;      // sum of weights, pixels: surfels below it are in no picture and keep their colour
constexpr float kLeastStart = 0.05f;  // display value: clamped colours below zero have no gradient

void encode_layer(SplatLayer& layer) {
  const size_t rest = layer.width(Attribute::ShRest);
  std::vector<float> sh(3 + rest);
  for (size_t i = 0; i < layer.size(); ++i) {
    std::copy_n(layer.at(Attribute::ShDc, i), 3, sh.begin());
    std::copy_n(layer.at(Attribute::ShRest, i), rest, sh.begin() + 3);
    encode_sh_for_display(sh);
    std::copy_n(sh.begin(), 3, layer.at(Attribute::ShDc, i));
    std::copy_n(sh.begin() + 3, rest, layer.at(Attribute::ShRest, i));
  }
}

// Raises the mean colour of surfels that are too dark for the fit.
void lift_black(SplatLayer& layer) {
  constexpr float kLeast = (kLeastStart - 0.5f) / kShDc;
  for (float& v : layer.values(Attribute::ShDc)) v = std::max(v, kLeast);
}

struct Target {
  View view;
  std::vector<float> srgb;  // [3, h, w]
};

std::vector<Target> composed_pictures(const TrainedScene& scene, std::span<const View> views, const PreviewFitDesc& desc) {
  ScenePainter painter(scene, {});
  const size_t count = std::min(views.size(), size_t(desc.views));
  std::vector<Target> out;
  for (size_t i = 0; i < count; ++i) {
    throw_if_interrupted();
    View view = views[i * views.size() / count];
    view.gain = {1, 1, 1};
    view.intrinsics = view.intrinsics.limited_to(desc.max_side);
    const ViewPicture picture = painter.picture(view);
    const size_t n = picture.srgb.pixel_count();
    std::vector<float> planes(3 * n);
    for (size_t p = 0; p < n; ++p)
      for (size_t c = 0; c < 3; ++c) planes[c * n + p] = picture.srgb.data()[3 * p + c];
    out.push_back({std::move(view), std::move(planes)});
  }
  return out;
}

}  // namespace

PreviewFit fit_preview(const TrainedScene& scene, std::span<const View> views, const PreviewFitDesc& desc) {
  VITRINE_CHECK(!views.empty(), "a preview needs views");
  const SplatScene& surfels = scene.surfels;
  PreviewFit out{surfels.opaque.size() > 0 ? surfels.opaque : surfels.diffuse};
  SplatLayer& layer = out.surfels;
  encode_layer(layer);
  const std::vector<Target> targets = composed_pictures(scene, views, desc);
  const auto renderer = make_renderer(Backend::Cpu);
  const double degree = layer.sh_degree() + 1, basis_energy = degree * degree / (4 * std::numbers::pi);
  RasterImages images, residual;
  std::vector<double> weight(layer.size(), 0);
  // One iteration: residuals of all pictures, and, except in the last, a step. Returns the mean squared residual.
  const auto round = [&](bool step) {
    SplatLayer grad = layer.zeros_like();
    std::ranges::fill(weight, 0.0);
    double squared = 0;
    size_t values = 0;
    for (const Target& target : targets) {
      throw_if_interrupted();
      const RasterDesc raster{.intrinsics = target.view.intrinsics,
                              .cam_from_world = target.view.cam_from_world,
                              .features = FeatureSet::ColorOnly,
                              .sh_degree = layer.sh_degree()};
      renderer->forward(layer, raster, images);
      residual.reset(raster);
      const auto color = images.plane(Aov::Color), r = residual.plane(Aov::Color);
      for (size_t p = 0; p < target.srgb.size(); ++p) {
        r[p] = target.srgb[p] - color[p];
        squared += double(r[p]) * r[p];
      }
      values += target.srgb.size();
      if (!step) continue;
      // The rasteriser's backward pass computes the sum of w Y r; other gradients are discarded.
      for (Aov aov : {Aov::ZDepth, Aov::Alpha, Aov::MedianZ}) residual.planes[size_t(aov)].clear();
      SurfelStatistics statistics;
      renderer->backward({.gradients = &residual}, grad, &statistics);
      for (size_t i = 0; i < weight.size(); ++i) weight[i] += double(statistics.weight[i]);
    }
    if (step)
      for (size_t i = 0; i < layer.size(); ++i) {
        if (!(weight[i] > kUnseen)) continue;
        const auto scale = float(1 / (basis_energy * weight[i]));
        for (Attribute a : {Attribute::ShDc, Attribute::ShRest})
          for (size_t c = 0; c < layer.width(a); ++c) layer.at(a, i)[c] += scale * grad.at(a, i)[c];
      }
    return squared / double(std::max<size_t>(1, values));
  };
  const auto psnr_of = [](double mean_square) { return -10 * std::log10(std::max(mean_square, 1e-12)); };
  out.psnr_before = psnr_of(round(false));
  const SplatLayer plain = layer;
  lift_black(layer);
  for (int step = 0; step < desc.steps; ++step) round(true);
  for (size_t i = 0; i < layer.size(); ++i)
    if (!(weight[i] > kUnseen)) std::copy_n(plain.at(Attribute::ShDc, i), 3, layer.at(Attribute::ShDc, i));
  out.psnr_after = psnr_of(round(false));
  return out;
}

}  // namespace vitrine
