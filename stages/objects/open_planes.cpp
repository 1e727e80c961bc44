#include "stages/objects/detect.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"
#include "core/observe/stereo/plane_fit.h"

namespace vitrine {

namespace {

constexpr double kOnPlane_rel = 0.02;      // of the longer side: distance within which surfels belong to a plane
constexpr double kBehindMirror = 0.3;      // weight of points inside a mirror's mask: many are virtual images
constexpr double kAboutShape_rel = 0.012;  // of the picture's longest side: margin around a shape that is also explained

// Sets the pixels of the shape, and a margin around them, to unknown.
void explain(const Shape& shape, Silhouette& silhouette) {
  const Intrinsics& k = silhouette.view.intrinsics;
  const int reach = int(std::ceil(kAboutShape_rel * k.longest_side()));
  Bounds3 about;  // bounds of the shape in the picture; z is depth
  for (const Vec3d& p : outer_points(shape)) {
    const Vec3d in_camera = silhouette.view.cam_from_world * p;
    const ImagePoint at = in_camera.z > 0 ? projected(in_camera, k) : ImagePoint{};
    about.extend(in_camera.z > 0 ? Vec3d{at.x, at.y, at.z} : Vec3d{0, 0, 0});
    if (!(in_camera.z > 0)) about.extend({double(k.width), double(k.height), 0});
  }
  const auto pixel = [&](double at, int size) { return int(std::clamp(at, 0.0, double(size))); };
  const int left = pixel(about.low.x - 1, k.width), right = pixel(about.high.x + 2, k.width);
  const int top = pixel(about.low.y - 1, k.height), bottom = pixel(about.high.y + 2, k.height);
  const Vec3d eye = silhouette.view.centre_in_world();
  for (int y = top; y < bottom; ++y)
    for (int x = left; x < right; ++x) {
      const Vec3d direction = silhouette.view.ray(x + 0.5, y + 0.5);
      if (!intersect(shape, {eye, direction})) continue;
      for (int v = std::max(0, y - reach); v <= std::min(k.height - 1, y + reach); ++v)
        for (int u = std::max(0, x - reach); u <= std::min(k.width - 1, x + reach); ++u) silhouette.value.at(u, v) = -1;
    }
}

}  // namespace

std::vector<Silhouette> unexplained(std::span<const Silhouette> silhouettes, const ShapeSet& found) {
  std::vector<Silhouette> out(silhouettes.begin(), silhouettes.end());
  parallel_for(out.size(), 1, [&](size_t v) {
    for (const ShapeSet::Entry& entry : found.entries) explain(entry.shape, out[v]);
  });
  return out;
}

ShapeSet open_planes(MaskClass kind, std::span<const Silhouette> silhouettes, std::span<const ScenePoint> points,
                     bool one_sided) {
  const bool glass = kind == MaskClass::Transparent;
  std::vector<Vec3d> positions;
  for (const ScenePoint& p : points) positions.push_back(p.position);
  ShapeSet out;
  for (const PlaneFit& fit :
       fit_planes(silhouettes, positions, {.inside_weight = glass ? 1 : kBehindMirror, .one_sided = one_sided}))
    out.entries.push_back({fit.plane, glass ? ShapeRole::Sheet : ShapeRole::Mirror, kOnPlane_rel * fit.plane.size(), -1, {}});
  return out;
}

}  // namespace vitrine
