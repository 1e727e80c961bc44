// The hull of transparent things: the points that every training photo that sees them shows inside its transparent mask
// (Laurentini 1994, with the depths of what is opaque: a photo says nothing about points behind it). Glass has no texture to
// match; its outline is what photos tell about its place.
#pragma once

#include <vector>

#include "core/math/vec.h"
#include "core/render/renderer.h"
#include "stages/optimize/capture.h"
#include "stages/optimize/targets.h"

namespace vitrine {

struct HullPoint {
  Vec3f position, normal;  // outwards, unit
};
struct Hull {
  std::vector<HullPoint> points;  // of the surface, on a grid
  float spacing = 0;              // of the grid
};

struct HullDesc {
  const Capture& capture;
  const Targets& targets;
  // [photo] z-depth of the diffuse layer at `level`, 0 = none; empty for held-out photos.
  std::span<const std::vector<float>> depths;
  size_t level = 1;
  int cells = 128;  // along the longest side of the hull
};
// Empty when no closed region agrees with the masks, of a window for example.
Hull transparent_hull(const HullDesc& desc);

}  // namespace vitrine
