#include "core/train/known_surface.h"

#include <utility>

namespace vitrine {

KnownSurface::KnownSurface(std::vector<Vec3f> points, float reach) : reach_(reach) {
  if (points.empty() || !(reach > 0)) return;
  points_ = std::make_shared<const std::vector<Vec3f>>(std::move(points));
  grid_ = std::make_shared<const PointGrid>(*points_, reach);
}

bool KnownSurface::near(const Vec3f& place) const { return grid_ && grid_->any(place, reach_); }

void KnownSurface::transfer(Archive& archive) {
  std::vector<Vec3f> points = points_ ? *points_ : std::vector<Vec3f>();
  archive.array(points);
  archive.value(reach_);
  if (archive.reads()) *this = KnownSurface(std::move(points), reach_);
}

}  // namespace vitrine
