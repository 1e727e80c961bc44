// Where the mesh is made: a box around what the photographs are about. Two kinds of capture are told apart by their cameras:
//   convergent   they look at one place (object on a table): the box holds the sparse points nearer to that place than the
//                cameras are, so a room's far walls do not cost resolution while table and objects stay; with fewer than 20
//                such points, a cube that reaches out to the cameras. Masks keep features off glass and gloss, hence sparse
//                points: what was trained there counts likewise, or a glass case on a table would be cut off above its foot
//   wide         they look along or outwards (street, room, flight): the box holds all sparse points but the outliers
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

struct RegionDesc {
  double reach_rel = 1.0;   // convergent: points nearer to the focus than this times the median camera distance
  double margin = 0.1;      // added on each side, of the longest side
  std::vector<double> box;  // x0 y0 z0 x1 y1 z1 in the scene frame; replaces all of the above when given
};

struct Region {
  Bounds3 box;
  bool convergent = false;
  Vec3d focus{};               // least-squares nearest point to the optical axes
  double camera_distance = 0;  // median, to the focus
  size_t points = 0;           // sparse points that shaped the box; 0: it comes from the cameras, or was given
  double extent() const;       // longest side
};

// Centres of the surfels of glass and mirrors: opaque by half and transparent or specular by half.
std::vector<Vec3d> glass_and_gloss(const SplatLayer& diffuse);

// `unmarked`: places as good as sparse points where there can be none, glass_and_gloss(); they have outliers of their own.
// Throws Error{Input} when there are too few sparse points to tell, and Error{Usage} for a box that is none.
Region scene_region(const ViewSet& set, const RegionDesc& desc, std::span<const Vec3d> unmarked = {});

}  // namespace vitrine
