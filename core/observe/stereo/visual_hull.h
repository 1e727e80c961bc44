// Visual hull of an object: the intersection of its silhouette cones (Laurentini, "The visual hull concept for silhouette-based
// image understanding", 1994). For glass and mirrors, where stereo finds no match, it is the only geometry from photos. It needs
// photos from all around: seen from one side the hull is an unbounded cone.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/voxel_grid.h"
#include "core/scene/shape/hit.h"
#include "core/observe/stereo/carving.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

struct HalfSpace {  // normal.X <= offset
  Vec3d normal;
  double offset = 0;
};

struct HullDesc {
  int resolution = 128;  // voxels along the longest side of the result
  CarvingRule rule = {};
  bool one_piece = false;              // keep the largest connected component: cones of few photos also intersect in empty space
  double reach = 1.2;                  // half edge of the searched cube around the cameras' centre
  std::vector<HalfSpace> within = {};  // limits of the searched space: an object on a table is not below it
  double most_one_sided = 0.8;  // limit on the length of the mean direction towards the cameras; 1 = all cameras in one direction
};

// Intersection of a ray with the hull; unit normal in the world, against the ray.
struct HullHit {
  double t;
  Vec3d normal;
};

class VisualHull {
 public:
  VisualHull() = default;  // empty
  VisualHull(std::span<const Silhouette> silhouettes, const HullDesc& desc);

  bool empty() const { return grid_.values.empty(); }
  double one_sidedness() const { return one_sidedness_; }       // of the cameras, as seen from the hull
  const Bounds3& bounds() const { return bounds_; }             // of the occupied voxels, without margin
  double voxel() const { return grid_.cell; }                   // edge
  const VoxelGrid<uint8_t>& carved() const { return carved_; }  // 1 inside, before the blur
  std::vector<ShapePoint> surface() const;                      // one for every voxel on the surface
  // First crossing of the smoothed surface, for t > 0. Thread-safe.
  std::optional<HullHit> first_hit(const Vec3d& origin, const Vec3d& direction) const;

 private:
  float occupancy(const Vec3d& p) const;  // trilinear, 0 outside
  Vec3d inwards(const Vec3d& p) const;    // gradient of the occupancy, times 3 voxels
  Bounds3 bounds_;
  VoxelGrid<uint8_t> carved_;
  VoxelGrid<float> grid_;  // occupancy, blurred
  double one_sidedness_ = 0;
};

// [view][h,w] 1 where the view's ray meets the hull. Stops early on an interrupt.
std::vector<std::vector<uint8_t>> silhouettes_of(const VisualHull& hull, std::span<const View> views);

}  // namespace vitrine
