#include "core/train/known_surface.h"

#include <utility>

namespace vitrine {

KnownSurface::KnownSurface(std::vector<Vec3f> points, float reach) : reach_(reach) {
  if (points.empty() || !(reach > 0)) return;
  points_ = std::make_shared<const std::vector<Vec3f>>(std::move(points));
  grid_ = std::make_shared<const PointGrid>(*points_, reach);
}

bool KnownSurface::near(const Vec3f& place) const { return grid_ && grid_->any(place, reach_); }

void KnownSurface::save(ArchiveWriter& out) const {
  out.array(points_ ? std::span<const Vec3f>(*points_) : std::span<const Vec3f>());
  out.value(reach_);
}

void KnownSurface::load(ArchiveReader& in) {
  std::vector<Vec3f> points;
  float reach = 0;
  in.array(points);
  in.value(reach);
  *this = KnownSurface(std::move(points), reach);
}

}  // namespace vitrine
