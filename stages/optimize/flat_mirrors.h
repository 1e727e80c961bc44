// Flat mirrors (known planes of role Mirror) when reflection begins. Photos show a world behind such a mirror, and stereo and
// training have put surfels there. They are pictures of what stands before it: they tell how the mirror stands, as the world
// behind it and the one before it are symmetrical, and then go to where they belong.
#pragma once

#include <span>
#include <vector>

#include "stages/optimize/layer_init.h"

namespace vitrine {

class FlatMirrors {
 public:
  // `gloss`: evidence of the specular masks. Keeps references.
  FlatMirrors(const LayerInitDesc& desc, const MaskEvidence& gloss, const SplatLayer& diffuse);

  bool empty() const { return mirrors_.empty(); }
  // Moves the planes of `shapes` (those of the desc) to where the world behind them, reflected, lies on the world before them:
  // point-to-plane registration (Chen and Medioni, "Object modelling by registration of multiple range images", 1992) of three
  // numbers. A plane stays where too little agrees.
  ShapeSet registered() const;
  // Surfels that photos see in a mirror go before it, with a colour that does not depend on the view: [surfel] 1 for those.
  std::vector<uint8_t> reflect_into_scene(const ShapeSet& shapes, SplatLayer& diffuse) const;

 private:
  struct Mirror {
    size_t entry;
    std::vector<uint32_t> behind;  // surfels that photos see in it
  };
  bool sees(const Plane& plane, double tolerance, const Vec3d& place, size_t& through) const;
  Plane registered(const Mirror& mirror) const;

  const LayerInitDesc& desc_;
  const MaskEvidence& gloss_;
  const SplatLayer& diffuse_;
  std::vector<Mirror> mirrors_;
};

}  // namespace vitrine
