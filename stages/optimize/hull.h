// Where the surface of glass and of polished metal is, as far as photos tell: on known shapes, and elsewhere on the visual hull
// of the masks (core/stereo/visual_hull), with the depths of opaque surfaces in front. Neither has a texture that stays on it;
// the silhouette tells its place.
#pragma once

#include <span>
#include <vector>

#include "core/shape/shape_set.h"
#include "core/train/capture.h"
#include "core/train/targets.h"

namespace vitrine {

struct HullPoint {
  Vec3f position, normal;  // outwards, unit
  bool known = false;      // on a shape, to a fraction of a pixel; or on a hull, which wavers
  float apart = 1;         // distance to its neighbours, of the hull's spacing
};
struct Hull {
  std::vector<HullPoint> points;  // of the surface
  float spacing = 0;              // of most of them
};

// Gloss: the specular mask without the transparent one, whose pixels then are unknown.
enum class HullClass : unsigned char { Glass, Gloss };

struct MaskHullDesc {
  HullClass kind = HullClass::Glass;

  const Capture& capture;
  const Targets& targets;
  const ShapeSet& shapes;  // those of the class's role count
  // [photo] z-depth of the diffuse layer at `level`, 0 = none; empty for held-out photos.
  std::span<const std::vector<float>> depths;
  size_t level = 0;
  int voxels = 128;  // along the longest side of the hull
};
// Empty when no closed region agrees with the masks, of a window for example, and no shape is known.
Hull mask_hull(const MaskHullDesc& desc);

}  // namespace vitrine
