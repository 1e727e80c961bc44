#include "core/render/volume/volume_ray.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"

namespace vitrine {

namespace {

RayBeam beam_of(std::span<const VolumeRay> rays) {
  RayBeam beam{rays[rays.size() / 2]};
  for (const VolumeRay& r : rays) {
    beam.radius = std::max(beam.radius, length(r.origin - beam.axis.origin));
    beam.spread = std::max(beam.spread, length(r.direction - beam.axis.direction));
  }
  return beam;
}

// Those of the pixels [x0, x1) x [y0, y1).
std::vector<VolumeRay> part(std::span<const VolumeRay> rays, int width, int x0, int y0, int x1, int y1) {
  std::vector<VolumeRay> out;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) out.push_back(rays[size_t(y) * size_t(width) + size_t(x)]);
  return out;
}

}  // namespace

RayTiles::RayTiles(std::span<const VolumeRay> rays, int width, const Vec3d& pivot)
    : width_(width), height_(width > 0 ? int(rays.size() / size_t(width)) : 0), pivot_(pivot) {
  VITRINE_CHECK(width > 0 && rays.size() == size_t(width) * size_t(height_) && !rays.empty(), "{} rays, {} in a row", rays.size(),
                width);
  std::vector<VolumeRay> near(rays.begin(), rays.end());
  for (VolumeRay& r : near) {
    const Vec3d from_pivot = r.origin - pivot;
    r.origin = from_pivot - dot(from_pivot, r.direction) * r.direction;
  }
  constexpr int kGroupSide = kSide * kGroup;
  for (int gy = 0; gy < height_; gy += kGroupSide)
    for (int gx = 0; gx < width_; gx += kGroupSide) {
      const int right = std::min(gx + kGroupSide, width_), bottom = std::min(gy + kGroupSide, height_);
      Group group{beam_of(part(near, width_, gx, gy, right, bottom)), {}};
      for (int y = gy; y < bottom; y += kSide)
        for (int x = gx; x < right; x += kSide) {
          group.tiles.push_back(static_cast<uint32_t>(tiles_.size()));
          Tile& tile = tiles_.emplace_back();
          tile.x = x, tile.y = y;
          tile.beam = beam_of(part(near, width_, x, y, std::min(x + kSide, width_), std::min(y + kSide, height_)));
          for (int i = 0; i < kRays; ++i) {
            const int px = std::min(x + i % kSide, width_ - 1), py = std::min(y + i / kSide, height_ - 1);
            const VolumeRay& r = near[size_t(py) * size_t(width_) + size_t(px)];
            for (size_t axis = 0; axis < 3; ++axis) {
              tile.origin[axis][size_t(i)] = static_cast<float>(r.origin[axis]);
              tile.direction[axis][size_t(i)] = static_cast<float>(r.direction[axis]);
            }
          }
        }
      groups_.push_back(std::move(group));
    }
}

}  // namespace vitrine
