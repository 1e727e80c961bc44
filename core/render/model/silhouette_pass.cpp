#include "core/render/model/silhouette_pass.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/render/model/gbuffer.h"
#include "core/render/model/opened_scene.h"
#include "core/render/model/sheet_pass.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr double kInFront_rel = 1. / 12;  // of the tolerance of the shape: surfaces farther in front are other objects
constexpr double kRounded_rel = 0.01;     // of its size: maximum distance by which a shape exceeds its bounds
constexpr double kLikeShape = 0.7;        // minimum cosine between the normals of a surfel of the shape and of the shape
constexpr float kCoreAlpha = 0.9f;        // minimum alpha of a pixel that shows only the shape
constexpr int kDonorSlack = 2;            // pixels farther than straight inwards from the silhouette
constexpr int kDonorReach = 2 * kSilhouetteBand + kDonorSlack;
constexpr uint8_t kAtEdge = 1, kInside = 2;  // in_band_
constexpr float kThinDonor = 2;    // pixels from the silhouette: minimum for material donors without pixels farther inside
constexpr float kDullRest = 0.1f;  // maximum k_s and tau of the background, which is rendered with its diffuse colour only
constexpr Aov kMaterials[] = {Aov::Color, Aov::F0, Aov::Roughness, Aov::SpecularWeight, Aov::Transmission};
constexpr Aov kShownByRest[] = {Aov::Color,        Aov::Normal, Aov::F0,    Aov::Roughness, Aov::SpecularWeight,
                                Aov::Transmission, Aov::ZDepth, Aov::Alpha, Aov::MedianZ};

size_t width_of(Aov a) { return static_cast<size_t>(row(a).width); }

// Pixel offsets, nearest first.
std::vector<std::pair<int, int>> around_by_distance() {
  std::vector<std::pair<int, int>> out;
  for (int y = -kDonorReach; y <= kDonorReach; ++y)
    for (int x = -kDonorReach; x <= kDonorReach; ++x)
      if (x * x + y * y <= kDonorReach * kDonorReach) out.emplace_back(x, y);
  std::ranges::stable_sort(out, {}, [](const auto& p) { return p.first * p.first + p.second * p.second; });
  return out;
}

// Mirror entries and the bounds of their surfels.
struct Located {
  const ShapeSet::Entry* entry;
  Bounds3 reach;
};
std::vector<Located> located(const ShapeSet& set) {
  std::vector<Located> out;
  for (const ShapeSet::Entry& e : set.entries) {
    if (e.role != ShapeRole::Mirror) continue;
    out.push_back({&e, bounds(e.shape, e.tolerance + kRounded_rel * size_of(e.shape))});
  }
  return out;
}

Vec3d surfel_normal(const SplatLayer& layer, size_t i) {
  const float* q = layer.at(Attribute::Rotation, i);
  return rotation_matrix(normalized(Quatd{q[0], q[1], q[2], q[3]})).column(2);
}

bool shows(const SplatLayer& diffuse, size_t i, const std::vector<Located>& shapes, float min_specular) {
  const float* m = diffuse.at(Attribute::Mean, i);
  const Vec3d mean{m[0], m[1], m[2]};
  for (const Located& s : shapes) {
    if (!s.reach.contains(mean) || !(sigmoid(*diffuse.at(Attribute::SpecularWeight, i)) > min_specular)) continue;
    const ShapePoint place = nearest(s.entry->shape, mean);
    if (length(place.position - mean) > s.entry->tolerance) continue;
    if (std::abs(dot(surfel_normal(diffuse, i), place.normal)) > kLikeShape) return true;
  }
  return false;
}

}  // namespace

void SilhouetteImages::clear() {
  pixels.clear();
  for (auto* values : {&rest, &grad_rest, &solid, &grad_covered}) values->clear();
}

// Renders the scene without the surfels of the shapes.
void SilhouettePass::draw_rest(const SplatScene& scene, Frame& frame) {
  const int width = frame.view->intrinsics.width;
  window_ = {};
  for (const SilhouettePixel& p : frame.silhouette.pixels)
    window_.extend(static_cast<int>(p.pixel) % width, static_cast<int>(p.pixel) / width);
  const std::vector<Located> shapes = located(*options_.set);
  const bool sheets = draws_sheets(frame.options);  // their surfels are not rendered
  rest_.choose(scene.diffuse, window_.view(*frame.view), [&](size_t i) {
    return !(sheets && is_glass(scene.diffuse, i)) && !shows(scene.diffuse, i, shapes, options_.min_specular);
  });
  wanted_.assign(window_.pixel_count(), 0);
  for (const SilhouettePixel& p : frame.silhouette.pixels) wanted_[in_window(p.pixel, width)] = 1;
  const DiffuseOptions& diffuse = frame.options.diffuse;
  rest_.draw({.features = FeatureSet::Material,
              .sh_degree = diffuse.sh_degree,
              .near_z = diffuse.near_z,
              .wanted = wanted_,
              .differentiable = true});
}

uint32_t SilhouettePass::donor(const SilhouettePixel& at, const Frame& frame) const {
  static const std::vector<std::pair<int, int>> around = around_by_distance();
  const int width = frame.view->intrinsics.width, height = frame.view->intrinsics.height;
  const int x = static_cast<int>(at.pixel) % width, y = static_cast<int>(at.pixel) / width;
  const std::span<const float> alpha = frame.diffuse.plane(Aov::Alpha);
  uint32_t thin = UINT32_MAX;
  const uint32_t root = options_.set->root(at.entry);
  const float reach = float(kSilhouetteBand + kDonorSlack) + (at.covered == 1 ? -at.away : at.away);
  for (const auto& [dx, dy] : around) {
    if (float(dx * dx + dy * dy) > reach * reach) break;
    const int u = x + dx, v = y + dy;
    if (u < 0 || v < 0 || u >= width || v >= height) continue;
    const auto pixel = static_cast<uint32_t>(v * width + u);
    const uint32_t shown = frame.silhouette.shapes[pixel];
    const bool alike = shown != 0 && options_.set->root(shown - 1) == root;
    if (!alike || !(alpha[pixel] > kCoreAlpha) || in_band_[pixel] == kAtEdge) continue;
    if (in_band_[pixel] == 0) return pixel;
    if (thin == UINT32_MAX) thin = pixel;
  }
  return thin;  // a thin part, entirely near its silhouette
}

// Whether the blend of the two pictures matches the pixel.
bool SilhouettePass::fits(const SilhouettePixel& at, const Frame& frame) const {
  const size_t w = in_window(at.pixel, frame.view->intrinsics.width);
  const float alpha = rest_.picture().plane(Aov::Alpha)[w];
  if (!(alpha > options_.min_alpha)) return at.covered == 1;
  if (at.covered == 0) return true;
  const double per_z = length(GBuffer(frame).ray(at.pixel).direction_per_z);
  const double in_front = (double(at.z) - double(rest_.picture().plane(Aov::ZDepth)[w]) / double(alpha)) * per_z;
  if (in_front > kInFront_rel * options_.set->entries[options_.set->root(at.entry)].tolerance) return false;
  return at.covered == 1 || std::max(rest_.picture().plane(Aov::SpecularWeight)[w],
                                     rest_.picture().plane(Aov::Transmission)[w]) <= kDullRest * alpha;
}

void SilhouettePass::show(const SilhouettePixel& at, uint32_t donor, Frame& frame) const {
  const size_t pixels = frame.pixel_count();
  if (at.covered == 0) {
    const size_t w = in_window(at.pixel, frame.view->intrinsics.width);
    for (const Aov a : kShownByRest)
      for (size_t c = 0; c < width_of(a); ++c)
        frame.diffuse.plane(a)[c * pixels + at.pixel] = rest_.picture().plane(a)[c * wanted_.size() + w];
  } else {
    for (const Aov a : kMaterials)
      for (size_t c = 0; c < width_of(a); ++c)
        frame.diffuse.plane(a)[c * pixels + at.pixel] = frame.diffuse.plane(a)[c * pixels + donor];
    const float alpha = frame.diffuse.plane(Aov::Alpha)[donor];
    frame.diffuse.plane(Aov::Alpha)[at.pixel] = alpha;
    frame.diffuse.plane(Aov::ZDepth)[at.pixel] = alpha * at.z;
    frame.diffuse.plane(Aov::MedianZ)[at.pixel] = at.z;
    for (size_t c = 0; c < 3; ++c) frame.diffuse.plane(Aov::Normal)[c * pixels + at.pixel] = alpha * at.normal[c];
  }
  for (size_t c = 0; c < 3; ++c) frame.linear[c * pixels + at.pixel] = frame.diffuse.plane(Aov::Color)[c * pixels + at.pixel];
  if (!frame.coats.entry.empty()) frame.coats.entry[at.pixel] = 0;  // the channels are no longer those of a coat
}

void SilhouettePass::forward(const SplatScene& scene, Frame& frame) {
  options_ = frame.options.shape;
  SilhouetteImages& out = frame.silhouette;
  donors_.clear();
  out.pixels.clear();
  if (!options_.silhouettes || out.shapes.empty()) return out.clear();
  std::vector<SilhouettePixel> candidates = silhouette_pixels(*options_.set, *frame.view);
  in_band_.assign(frame.pixel_count(), 0);
  for (const SilhouettePixel& p : candidates) in_band_[p.pixel] = p.covered == 1 && p.away >= kThinDonor ? kInside : kAtEdge;
  for (const SilhouettePixel& p : candidates) {
    if (frame.sheets.shows(p.pixel)) continue;  // glass is in front, or behind the silhouette
    if (const uint32_t from = donor(p, frame); from != UINT32_MAX) out.pixels.push_back(p), donors_.push_back(from);
  }
  if (out.pixels.empty()) return out.clear();
  draw_rest(scene, frame);
  size_t kept = 0;
  for (size_t i = 0; i < out.pixels.size(); ++i)
    if (fits(out.pixels[i], frame)) out.pixels[kept] = out.pixels[i], donors_[kept++] = donors_[i];
  out.pixels.resize(kept), donors_.resize(kept);
  if (kept == 0) return out.clear();
  out.rest.assign(3 * kept, 0.f), out.grad_rest.assign(3 * kept, 0.f), out.solid.assign(3 * kept, 0.f);
  const std::span<const float> color = rest_.picture().plane(Aov::Color);
  for (size_t i = 0; i < kept; ++i) {
    const SilhouettePixel& p = out.pixels[i];
    for (size_t c = 0; c < 3; ++c)
      out.rest[3 * i + c] = color[c * wanted_.size() + in_window(p.pixel, frame.view->intrinsics.width)];
    show(p, donors_[i], frame);
  }
}

// Moves the channel gradients of later passes and losses to the pixels the channels were copied from.
void SilhouettePass::backward(const SplatScene&, Frame& frame, SplatScene& grad) {
  SilhouetteImages& out = frame.silhouette;
  if (out.pixels.empty()) return;
  const size_t pixels = frame.pixel_count(), window = wanted_.size();
  const int width = frame.view->intrinsics.width;
  RasterImages& grad_channels = frame.grad_diffuse;
  error_image_.assign(frame.error_image.empty() ? 0 : window, 0.f);
  // In reverse order, since donors of thin parts are silhouette pixels themselves.
  for (size_t i = out.pixels.size(); i-- > 0;) {
    const SilhouettePixel& p = out.pixels[i];
    const size_t w = in_window(p.pixel, width);
    const bool own = p.covered > 0 && donors_[i] == p.pixel;  // it keeps its own materials
    for (size_t c = 0; c < 3; ++c) {
      grad_channels.plane(Aov::Color)[c * pixels + p.pixel] += frame.grad_linear[c * pixels + p.pixel];
      frame.grad_linear[c * pixels + p.pixel] = 0;
      rest_.gradients().plane(Aov::Color)[c * window + w] += out.grad_rest[3 * i + c];
    }
    if (p.covered == 0) {
      for (const Aov a : kShownByRest)
        for (size_t c = 0; c < width_of(a); ++c)
          rest_.gradients().plane(a)[c * window + w] += grad_channels.plane(a)[c * pixels + p.pixel];
    } else {
      for (const Aov a : kMaterials)
        for (size_t c = 0; c < width_of(a) && !own; ++c)
          grad_channels.plane(a)[c * pixels + donors_[i]] += grad_channels.plane(a)[c * pixels + p.pixel];
      float alpha = grad_channels.plane(Aov::Alpha)[p.pixel] + p.z * grad_channels.plane(Aov::ZDepth)[p.pixel];
      for (size_t c = 0; c < 3; ++c) alpha += p.normal[c] * grad_channels.plane(Aov::Normal)[c * pixels + p.pixel];
      if (own) {
        for (const Aov a : {Aov::Normal, Aov::ZDepth, Aov::MedianZ})
          for (size_t c = 0; c < width_of(a); ++c) grad_channels.plane(a)[c * pixels + p.pixel] = 0;
        grad_channels.plane(Aov::Alpha)[p.pixel] = alpha;
        continue;
      }
      grad_channels.plane(Aov::Alpha)[donors_[i]] += alpha;
    }
    for (const AovRow& r : kAovs)
      for (size_t c = 0; c < width_of(r.id) && !grad_channels.plane(r.id).empty(); ++c)
        grad_channels.plane(r.id)[c * pixels + p.pixel] = 0;
    if (error_image_.empty()) continue;
    error_image_[w] = (1 - p.covered) * frame.error_image[p.pixel];
    frame.error_image[p.pixel] = 0;  // no surfel of the shape is visible there
  }
  rest_.backward(error_image_, grad.diffuse, frame.statistics);
}

void SilhouetteBlendPass::forward(const SplatScene&, Frame& frame) {
  SilhouetteImages& out = frame.silhouette;
  const size_t pixels = frame.pixel_count();
  LayerImages& layers = frame.layers;
  for (size_t i = 0; i < out.pixels.size(); ++i) {
    const SilhouettePixel& p = out.pixels[i];
    if (p.covered == 0 || p.covered == 1) continue;
    for (size_t c = 0; c < 3; ++c) {
      const size_t at = c * pixels + p.pixel;
      const float rest = (1 - p.covered) * out.rest[3 * i + c];
      out.solid[3 * i + c] = frame.linear[at];
      frame.linear[at] = p.covered * frame.linear[at] + rest;
      if (layers.diffuse.empty()) continue;
      for (auto* plane : {&layers.diffuse, &layers.reflection, &layers.transmission}) (*plane)[at] *= p.covered;
      layers.diffuse[at] += rest;
    }
  }
}

void SilhouetteBlendPass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  SilhouetteImages& out = frame.silhouette;
  const size_t pixels = frame.pixel_count();
  out.grad_covered.assign(out.pixels.size(), 0.f);
  for (size_t i = 0; i < out.pixels.size(); ++i) {
    const SilhouettePixel& p = out.pixels[i];
    if (p.covered == 0 || p.covered == 1) continue;
    for (size_t c = 0; c < 3; ++c) {
      float& grad = frame.grad_linear[c * pixels + p.pixel];
      out.grad_covered[i] += grad * (out.solid[3 * i + c] - out.rest[3 * i + c]);
      out.grad_rest[3 * i + c] = (1 - p.covered) * grad;
      grad *= p.covered;
    }
  }
}

}  // namespace vitrine
