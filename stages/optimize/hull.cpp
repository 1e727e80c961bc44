#include "stages/optimize/hull.h"

#include <algorithm>
#include <cmath>

#include "core/base/log.h"
#include "core/base/parallel.h"
#include "core/camera/projection.h"
#include "core/shape/surface_samples.h"
#include "core/stereo/visual_hull.h"

namespace vitrine {

namespace {

constexpr int kSilhouetteSide = 640;  // pixels: silhouettes tell a place to a fraction of one, and large ones fill memory
constexpr CarvingRule kRule{.dissent = 0.08, .seen_share = 0.3, .inside_share = 0.6};
constexpr double kExplained = 2.5;   // voxels: a hull lies so far from a shape that it shows
constexpr double kBeside = 0.2;      // of the photos that show a point inside the mask: so many show it beside all shapes
constexpr double kShapeCells = 100;  // along shapes without a hull: the spacing of points on them
// Appendages bend faster than what they stand out of: points in place of one.
constexpr double kCrowd = 6;

MaskClass mask_class(HullClass kind) { return kind == HullClass::Glass ? MaskClass::Transparent : MaskClass::Specular; }

// Without values when the photo has no mask.
Silhouette silhouette_of(const MaskHullDesc& desc, uint32_t photo) {
  const auto& levels = desc.capture.photos[photo].levels;
  size_t level = desc.level;
  while (level + 1 < kLevels && levels[level].view.intrinsics.longest_side() > kSilhouetteSide) ++level;
  Silhouette out{levels[level].view, {}};
  const auto& masks = desc.targets.photos[photo][level].masks;
  const auto& mask = masks[size_t(mask_class(desc.kind))];
  if (mask.empty()) return out;
  const auto& glass = masks[size_t(MaskClass::Transparent)];
  const bool hides = desc.kind == HullClass::Gloss && !glass.empty();
  const auto& coat = desc.targets.photos[photo][level].coat;  // in front of what mirrors, perhaps
  const bool coated = desc.kind == HullClass::Gloss && !coat.empty();
  const Intrinsics &k = out.view.intrinsics, &full = levels[desc.level].view.intrinsics;
  out.value = ImageF(k.width, k.height, 1);
  out.depth = ImageF(k.width, k.height, 1);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const size_t i = size_t(y) * size_t(k.width) + size_t(x);
      out.value.at(x, y) = (hides && glass[i] >= 128) || (coated && coat[i] >= 128) ? -1.f : float(mask[i]) / 255.f;
      out.depth.at(x, y) =
          desc.depths[photo][size_t(y * full.height / k.height) * size_t(full.width) + size_t(x * full.width / k.width)];
    }
  return out;
}

Bounds3 bounds_of(const ShapeSet& shapes, const VisualHull& hull) {
  Bounds3 out = hull.bounds();
  for (const ShapeSet::Entry& e : shapes.entries) {
    const Bounds3 b = bounds(e.shape);
    out.extend(b.low), out.extend(b.high);
  }
  return out;
}

void put_on_shapes(const ShapeSet& shapes, Hull& hull) {
  for (const ShapeSet::Entry& e : shapes.entries) {
    const double crowd = e.parent >= 0 ? 1 / std::sqrt(kCrowd) : 1;
    for (const ShapePoint& p : surface_samples(e.shape, crowd * double(hull.spacing))) {
      if (e.parent >= 0) {  // the root of an appendage
        const ShapePoint on = nearest(shapes.entries[size_t(e.parent)].shape, p.position);
        if (dot(p.position - on.position, on.normal) < 0) continue;
      }
      hull.points.push_back({cast<float>(p.position), cast<float>(p.normal), true, static_cast<float>(crowd)});
    }
  }
}

// [point] near a shape.
std::vector<uint8_t> near_shapes(const ShapeSet& shapes, const VisualHull& hull, const std::vector<ShapePoint>& surface) {
  std::vector<uint8_t> out(surface.size());
  parallel_for(surface.size(), 256, [&](size_t i) {
    const Vec3d& p = surface[i].position;
    out[i] = std::ranges::any_of(shapes.entries, [&](const ShapeSet::Entry& e) {
      return length(nearest(e.shape, p).position - p) <= std::max(e.tolerance, kExplained * hull.voxel());
    });
  });
  return out;
}

// Whether photos show the point inside the mask and beside the silhouettes of all shapes. A hull bulges between the cones of few
// photos, and behind opaque surfaces; what bulges so lies in the silhouettes of the shape.
bool shown_beside(const ShapeSet& shapes, const std::vector<Silhouette>& silhouettes, const Vec3d& p) {
  size_t inside = 0, beside = 0;
  for (const Silhouette& s : silhouettes) {
    const auto q = image_point(p, s.view);
    if (!q || s.value.at(int(q->x), int(q->y)) < 0.5f) continue;
    const Vec3d eye = s.view.centre_in_world();
    ++inside;
    beside += std::ranges::none_of(shapes.entries, [&](const ShapeSet::Entry& e) {
      return intersect(e.shape, {eye, p - eye}).has_value();
    });
  }
  return beside >= kRule.fewest_views && double(beside) >= kBeside * double(inside);
}

// Points of the hull's surface that no shape explains.
std::vector<ShapePoint> beside_shapes(const ShapeSet& shapes, const VisualHull& hull,
                                      const std::vector<Silhouette>& silhouettes) {
  const std::vector<ShapePoint> surface = hull.surface();
  if (shapes.entries.empty()) return surface;
  std::vector<uint8_t> keep = near_shapes(shapes, hull, surface);
  parallel_for(surface.size(), 64,
               [&](size_t i) { keep[i] = !keep[i] && shown_beside(shapes, silhouettes, surface[i].position); });
  std::vector<ShapePoint> out;
  for (size_t i = 0; i < surface.size(); ++i)
    if (keep[i]) out.push_back(surface[i]);
  return out;
}

}  // namespace

Hull mask_hull(const MaskHullDesc& desc) {
  std::vector<Silhouette> silhouettes;
  for (uint32_t photo : desc.capture.train)
    if (Silhouette s = silhouette_of(desc, photo); !s.value.empty()) silhouettes.push_back(std::move(s));
  const ShapeSet shapes =
      desc.shapes.without(ShapeRole::Coat).without(desc.kind == HullClass::Glass ? ShapeRole::Mirror : ShapeRole::Sheet);
  const VisualHull carved(silhouettes,
                          {.resolution = desc.voxels, .rule = kRule, .blur_passes = 1, .flat_faces = shapes.entries.empty()});
  Hull hull;
  const Bounds3 around = bounds_of(shapes, carved);
  if (around.empty()) return hull;
  const Vec3d extent = around.high - around.low;
  hull.spacing = static_cast<float>(carved.empty() ? std::max({extent.x, extent.y, extent.z}) / kShapeCells : carved.voxel());
  put_on_shapes(shapes, hull);
  const size_t on_shapes = hull.points.size();
  for (const ShapePoint& p : beside_shapes(shapes, carved, silhouettes))
    hull.points.push_back({cast<float>(p.position), cast<float>(p.normal), false});
  log_info("{} {}: {} points of shapes, {} elsewhere on its hull", name(mask_class(desc.kind)), shapes.entries.size(), on_shapes,
           hull.points.size() - on_shapes);
  return hull;
}

}  // namespace vitrine
