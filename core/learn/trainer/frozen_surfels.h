// Gradient filters for glass and mirrors: images seen through or in them must not move their own surfels.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/foundation/math/kd_tree.h"
#include "core/learn/optim/archive.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Points of a fitted box, surface of revolution or fine visual hull of a specular object, known more accurately than its
// surfels. Surfels near it keep their geometry (freeze_mirrors).
class KnownSurface {
 public:
  KnownSurface() = default;
  // `reach`: maximum distance between the points and the surfels of the surface; scene units.
  KnownSurface(std::vector<Vec3f> points, float reach);
  bool empty() const { return points_ == nullptr; }
  bool near(const Vec3f& place) const;

  void transfer(Archive& archive);

 private:
  std::shared_ptr<const std::vector<Vec3f>> points_;  // of the tree
  std::shared_ptr<const KdTreef> tree_;
  float reach_ = 0;
};

// `damping` (of geometry and opacity, Adam::step) is interpolated from 1 to `glass_factor` by the transmission of a surfel, and
// its `error` from full to zero. Non-glass surfels get no gradient of tau: masks extend over the rim of the glass, and objects
// behind it must not become transparent.
void freeze_glass(const SplatLayer& diffuse, float glass_factor, std::vector<float>& damping, std::span<float> error,
                  SplatLayer& grad);

// Sets f0 and k_s of all glass surfels to their means.
void share_glass(SplatLayer& diffuse);

// Damps specular surfels near `known`: `damping` (empty: ones) is multiplied by 1 to `mirror_factor` according to their specular
// weight. The known surface is more accurate than a mirror reflection can determine.
void freeze_mirrors(const SplatLayer& diffuse, const KnownSurface& known, float mirror_factor, std::vector<float>& damping);

}  // namespace vitrine
