// Where the surface of something that reflects is known better than its surfels know it: points of a fitted box, of a surface of
// revolution or of a fine visual hull. Surfels near it keep their geometry (freeze_mirrors); glossy surfels elsewhere do not.
#pragma once

#include <memory>
#include <vector>

#include "core/math/point_grid.h"
#include "core/optim/archive.h"

namespace vitrine {

class KnownSurface {
 public:
  KnownSurface() = default;
  // `reach`: how far from the points surfels lie that show the surface, at most; scene units.
  KnownSurface(std::vector<Vec3f> points, float reach);
  bool empty() const { return points_ == nullptr; }
  bool near(const Vec3f& place) const;

  void transfer(Archive& archive);

 private:
  std::shared_ptr<const std::vector<Vec3f>> points_;  // grid_ looks at them
  std::shared_ptr<const PointGrid> grid_;
  float reach_ = 0;
};

}  // namespace vitrine
