// Registration of flat mirrors (known planes of role Mirror) when the reflection layer begins. Training has placed surfels behind
// such a mirror, at the virtual images of the scene in front of it. The mirror symmetry between both gives the exact plane; then
// the virtual surfels are reflected to their real positions.
#pragma once

#include <span>
#include <vector>

#include "stages/optimize/layer_init.h"

namespace vitrine {

class FlatMirrors {
 public:
  // `specular`: evidence of the specular masks. Keeps references.
  FlatMirrors(const LayerInitDesc& desc, const MaskEvidence& specular, const SplatLayer& diffuse);

  bool empty() const { return mirrors_.empty(); }
  // Moves the planes of `shapes` (those of the desc) by point-to-plane registration (Chen and Medioni, "Object modelling by
  // registration of multiple range images", 1992) of three parameters: the reflected virtual surfels must lie on the real
  // surfaces. A plane with too few matching pairs is unchanged.
  ShapeSet registered() const;
  // Reflects the virtual surfels to the front of the mirror, with view-independent colour. Returns [surfel] 1 for those.
  std::vector<uint8_t> reflect_into_scene(const ShapeSet& shapes, SplatLayer& diffuse) const;

 private:
  struct Mirror {
    size_t entry;
    std::vector<uint32_t> behind;  // surfels that photos see in the mirror
  };
  bool sees(const Plane& plane, double tolerance, const Vec3d& place, size_t& through) const;
  Plane registered(const Mirror& mirror) const;

  const LayerInitDesc& desc_;
  const MaskEvidence& specular_;
  const SplatLayer& diffuse_;
  std::vector<Mirror> mirrors_;
};

}  // namespace vitrine
