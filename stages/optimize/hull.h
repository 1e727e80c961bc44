// The hull of things of glass or of polished metal: the points that every training photo that sees them shows inside its mask
// (Laurentini 1994, with the depths of what is dull: a photo says nothing about points behind it). Neither has a texture that
// stays on it; the outline is what photos tell about its place. (core/stereo/visual_hull knows masks alone, and gives a surface
// that rays meet; here dull things that stand in front have their say, and the surface is a set of points.)
#pragma once

#include <optional>
#include <vector>

#include "core/mesh/tri_mesh.h"
#include "core/render/renderer.h"
#include "core/shape/box.h"
#include "core/stereo/revolution_fit.h"
#include "core/train/capture.h"
#include "core/train/targets.h"

namespace vitrine {

struct HullPoint {
  Vec3f position, normal;  // outwards, unit
  bool known = false;      // by a box, a solid of revolution or a fine hull, to a fraction of a pixel; or as a hull wavers
  float apart = 1;         // distance to its neighbours, of the hull's spacing
};
struct Hull {
  std::vector<HullPoint> points;          // of the surface, on a grid
  float spacing = 0;                      // of the grid
  std::vector<SolidOfRevolution> solids;  // that pieces of it are
  TriMesh beside;                         // appendages of the solids
  std::optional<Box> box;                 // where the outlines are those of one
};

// Gloss: the specular mask without the transparent one, whose pixels then say nothing.
enum class HullClass : unsigned char { Glass, Gloss };

struct MaskHullDesc {
  HullClass kind = HullClass::Glass;

  const Capture& capture;
  const Targets& targets;
  // [photo] z-depth of the diffuse layer at `level`, 0 = none; empty for held-out photos.
  std::span<const std::vector<float>> depths;
  size_t level = 0;
  int cells = 128;  // along the longest side of the hull
};
// Empty when no closed region agrees with the masks, of a window for example.
Hull mask_hull(const MaskHullDesc& desc);

}  // namespace vitrine
