#include "stages/optimize/initialise.h"

#include <algorithm>
#include <cmath>

#include "core/scene/shape/shape_set.h"

namespace vitrine {

namespace {

constexpr double kSeedCells = 128;  // along the longest side of all shapes
constexpr double kCrowd = 6;        // density factor of appendages

}  // namespace

SurfaceSeeds surface_seeds(const ShapeSet& shapes) {
  SurfaceSeeds out;
  Bounds3 around;
  for (const ShapeSet::Entry& e : shapes.entries) {
    const Bounds3 b = bounds(e.shape);
    around.extend(b.low), around.extend(b.high);
  }
  if (around.empty()) return out;
  const Vec3d extent = around.high - around.low;
  const double spacing = std::max({extent.x, extent.y, extent.z}) / kSeedCells;
  out.spacing = static_cast<float>(spacing);
  for (const ShapeSet::Entry& e : shapes.entries) {
    const double crowd = e.parent >= 0 ? 1 / std::sqrt(kCrowd) : 1;
    for (const ShapePoint& p : surface_samples(e.shape, crowd * spacing)) {
      if (e.parent >= 0) {
        const ShapePoint on = nearest(shapes.entries[size_t(e.parent)].shape, p.position);
        if (dot(p.position - on.position, on.normal) < 0) continue;
      }
      out.points.push_back({cast<float>(p.position), cast<float>(p.normal), e.exact, static_cast<float>(crowd)});
    }
  }
  return out;
}

}  // namespace vitrine
