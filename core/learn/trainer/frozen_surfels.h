// Gradients of glass and mirrors: what is seen through or in them must not move their own surfels.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/foundation/math/kd_tree.h"
#include "core/learn/optim/archive.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Points of a fitted box, of a surface of revolution or of a fine visual hull that reflects, where the surface is known better
// than by surfels. Surfels near it keep their geometry (freeze_mirrors).
class KnownSurface {
 public:
  KnownSurface() = default;
  // `reach`: how far from the points surfels lie that show the surface, at most; scene units.
  KnownSurface(std::vector<Vec3f> points, float reach);
  bool empty() const { return points_ == nullptr; }
  bool near(const Vec3f& place) const;

  void transfer(Archive& archive);

 private:
  std::shared_ptr<const std::vector<Vec3f>> points_;  // of the tree
  std::shared_ptr<const KdTreef> tree_;
  float reach_ = 0;
};

// `damping` (of geometry and opacity, Adam::step) goes from 1 to `glass_factor` with the transmission of a surfel, and its
// `error` from all to none. Surfels that are no glass get no gradient of tau: masks reach over the rim of the glass, and objects
// behind it must not become transparent.
void freeze_glass(const SplatLayer& diffuse, float glass_factor, std::vector<float>& damping, std::span<float> error,
                  SplatLayer& grad);

// One f0 and one k_s for all surfels of glass: their means.
void share_glass(SplatLayer& diffuse);

// Surfels near `known` stay where they are as far as they reflect: `damping` (empty: ones) is multiplied by 1 to `gloss_factor`.
// The surface is known better than a picture in a mirror tells.
void freeze_mirrors(const SplatLayer& diffuse, const KnownSurface& known, float gloss_factor, std::vector<float>& damping);

}  // namespace vitrine
