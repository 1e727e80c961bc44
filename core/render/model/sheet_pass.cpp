#include "core/render/model/sheet_pass.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/render/model/gbuffer.h"
#include "core/render/model/kernels/fresnel.h"

namespace vitrine {

namespace {

constexpr size_t kSheetRows = 8;
constexpr float kSheetSpecular = 0.002f;  // k_s: above clear_gate's threshold, and negligible compared with Fresnel
constexpr float kSheetRoughness = 0.05f;
constexpr float kFrameSpecular = 0.1f;  // minimum k_s of metal
constexpr float kBehindAlpha = 0.5f;    // of the surfels: below it, nothing is in front of the glass
constexpr std::array<std::array<double, 2>, 4> kQuarters{{{0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}}};
constexpr Aov kOverwritten[] = {Aov::Normal,    Aov::ZDepth,         Aov::MedianZ,     Aov::F0,
                                Aov::Roughness, Aov::SpecularWeight, Aov::Transmission};

// Surface of the surfels in a pixel.
struct Shown {
  double z;      // z-depth; infinite where alpha is low
  bool mirrors;  // metal: at thin glass, its frame
};

// Casts camera rays against the glass shapes of a scene.
class SheetRays {
 public:
  SheetRays(const Frame& frame) : set_(*frame.options.shape.set), view_(*frame.view), eye_(view_.centre_in_world()) {
    for (const ShapeSet::Entry& e : set_.entries) {
      if (!is_glass(e.role)) continue;
      const Bounds3 b = bounds(e.shape);
      all_.extend(b.low), all_.extend(b.high);
    }
  }
  // First hit along (x, y) of the picture, in front of the surfels.
  std::optional<ShapeSet::Hit> first(double x, double y, const Shown& shown) const {
    const Vec3d per_z = view_.ray(x, y);
    const Ray ray{eye_, per_z};
    if (!may_meet(all_, ray)) return std::nullopt;
    const double speed = length(per_z);
    const auto accepts = [&](const ShapeSet::Hit& h) {
      const ShapeSet::Entry& e = set_.entries[h.entry];
      return e.is_clear(h.element) && (shown.z - h.t) * speed > (shown.mirrors ? e.tolerance : -e.tolerance);
    };
    const auto sheet = set_.first_hit(ray, ShapeRole::Sheet, accepts), solid = set_.first_hit(ray, ShapeRole::Solid, accepts);
    return !solid || (sheet && sheet->t < solid->t) ? sheet : solid;
  }

 private:
  static bool may_meet(const Bounds3& box, const Ray& ray) {
    double from = 0, to = 1e300;
    for (size_t i = 0; i < 3; ++i) {
      const double a = (box.low[i] - ray.origin[i]) / ray.direction[i], b = (box.high[i] - ray.origin[i]) / ray.direction[i];
      from = std::max(from, std::min(a, b)), to = std::min(to, std::max(a, b));
    }
    return from <= to;
  }

  const ShapeSet& set_;
  const View& view_;
  Vec3d eye_;
  Bounds3 all_;  // of all glass shapes
};

Shown shown_by_surfels(const Frame& frame, bool reflects, size_t pixel) {
  const float z = frame.diffuse.plane(Aov::MedianZ)[pixel];
  const bool shows = frame.diffuse.plane(Aov::Alpha)[pixel] > kBehindAlpha && z > 0;
  return {shows ? double(z) : INFINITY, reflects && frame.diffuse.plane(Aov::SpecularWeight)[pixel] > kFrameSpecular};
}

}  // namespace

void SheetImages::clear() {
  entry.clear(), element.clear(), solid.clear();
  for (auto* plane : {&coverage, &behind_alpha, &behind_median}) plane->clear();
}

bool draws_sheets(const ImageOptions& options) {
  return options.transmission.glass == Glass::Thin && options.shape.set && options.shape.set->has_glass();
}

// Casts rays through all pixel centres.
void SheetPass::look(const Frame& frame, bool reflects) {
  const SheetRays rays(frame);
  const auto width = static_cast<size_t>(frame.view->intrinsics.width),
             height = static_cast<size_t>(frame.view->intrinsics.height);
  middles_.assign(width * height, {});
  parallel_for((height + kSheetRows - 1) / kSheetRows, 1, [&](size_t band) {
    for (size_t y = band * kSheetRows; y < std::min((band + 1) * kSheetRows, height); ++y)
      for (size_t x = 0; x < width; ++x) {
        const size_t pixel = y * width + x;
        const auto hit = rays.first(double(x) + 0.5, double(y) + 0.5, shown_by_surfels(frame, reflects, pixel));
        if (hit) middles_[pixel] = {hit->entry + 1, hit->element, static_cast<float>(hit->t), cast<float>(hit->normal)};
      }
  });
}

void SheetPass::forward(const SplatScene& scene, Frame& frame) {
  SheetImages& out = frame.sheets;
  out.clear();
  if (!draws_sheets(frame.options)) return;
  const bool reflects = scene.reflection.size() > 0;
  look(frame, reflects);
  const auto width = static_cast<size_t>(frame.view->intrinsics.width),
             height = static_cast<size_t>(frame.view->intrinsics.height);
  const size_t pixels = frame.pixel_count();
  if (std::ranges::none_of(middles_, [](const Seen& s) { return s.entry != 0; })) return;
  out.entry.assign(pixels, 0), out.element.assign(pixels, 0), out.solid.assign(pixels, 0);
  out.coverage.assign(pixels, 0.f);
  const auto alpha = frame.diffuse.plane(Aov::Alpha), median = frame.diffuse.plane(Aov::MedianZ);
  out.behind_alpha.assign(alpha.begin(), alpha.end());
  out.behind_median.assign(median.begin(), median.end());
  const SheetRays rays(frame);
  const auto at_silhouette = [&](size_t x, size_t y) {
    const uint32_t own = middles_[y * width + x].entry;
    return (x > 0 && middles_[y * width + x - 1].entry != own) || (x + 1 < width && middles_[y * width + x + 1].entry != own) ||
           (y > 0 && middles_[(y - 1) * width + x].entry != own) ||
           (y + 1 < height && middles_[(y + 1) * width + x].entry != own);
  };
  RasterImages& channels = frame.diffuse;
  const auto normal = channels.plane(Aov::Normal), f0 = channels.plane(Aov::F0);
  parallel_for((height + kSheetRows - 1) / kSheetRows, 1, [&](size_t band) {
    for (size_t y = band * kSheetRows; y < std::min((band + 1) * kSheetRows, height); ++y)
      for (size_t x = 0; x < width; ++x) {
        const size_t pixel = y * width + x;
        Seen seen = middles_[pixel];
        float coverage = seen.entry != 0;
        if (at_silhouette(x, y)) {
          const Shown shown = shown_by_surfels(frame, reflects, pixel);
          coverage = 0;
          for (const auto& [dx, dy] : kQuarters) {
            const auto hit = rays.first(double(x) + dx, double(y) + dy, shown);
            if (!hit) continue;
            coverage += 1.f / kQuarters.size();
            if (seen.entry == 0) seen = {hit->entry + 1, hit->element, static_cast<float>(hit->t), cast<float>(hit->normal)};
          }
        }
        if (!(coverage > 0)) continue;
        const bool solid = frame.options.shape.set->entries[seen.entry - 1].role == ShapeRole::Solid;
        out.entry[pixel] = seen.entry, out.element[pixel] = seen.element, out.solid[pixel] = solid;
        out.coverage[pixel] = coverage;
        const float a = std::max(channels.plane(Aov::Alpha)[pixel], coverage);
        channels.plane(Aov::Alpha)[pixel] = a;
        for (size_t c = 0; c < 3; ++c) {
          normal[c * pixels + pixel] = a * seen.normal[c];
          f0[c * pixels + pixel] = a * static_cast<float>(solid ? kWallReflectance : kPaneReflectance);
        }
        channels.plane(Aov::ZDepth)[pixel] = a * seen.z;
        channels.plane(Aov::MedianZ)[pixel] = seen.z;
        channels.plane(Aov::Roughness)[pixel] = a * kSheetRoughness;
        channels.plane(Aov::SpecularWeight)[pixel] = kSheetSpecular;
        channels.plane(Aov::Transmission)[pixel] = coverage;
      }
  });
}

void SheetPass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  const SheetImages& s = frame.sheets;
  if (s.empty()) return;
  const size_t pixels = frame.pixel_count();
  RasterImages& grad = frame.grad_diffuse;
  for (size_t pixel = 0; pixel < pixels; ++pixel) {
    if (s.entry[pixel] == 0) continue;
    for (const Aov a : kOverwritten) {
      const auto plane = grad.plane(a);
      for (size_t i = pixel; i < plane.size(); i += pixels) plane[i] = 0;
    }
    if (s.coverage[pixel] > s.behind_alpha[pixel]) grad.plane(Aov::Alpha)[pixel] = 0;
  }
}

}  // namespace vitrine
