// The visual hull of an object: what is left of space when every mask has cut away what it shows to be empty (Laurentini, "The
// visual hull concept for silhouette-based image understanding", 1994). For glass and mirrors, whose pixels no stereo matches, it
// is the only geometry that the photos give. It needs photos from around: seen from one side alone a hull is a cone to infinity.
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
  int resolution = 128;  // voxels along the longest side of what is left
  CarvingRule rule = {};
  bool one_piece = false;              // keep the largest connected part: cones of few photos also meet where nothing is
  double reach = 1.2;                  // half edge of the cube around the cameras' centre that is looked at
  std::vector<HalfSpace> within = {};  // all that is looked at: a thing on a table is not below it
  double most_one_sided = 0.8;         // length of the mean direction towards the cameras; 1 = all look from one place
};

// Where a ray meets the hull; the normal is of unit length, in the world, against the ray.
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
  const Bounds3& bounds() const { return bounds_; }             // of what is left, without the room around it
  double voxel() const { return grid_.cell; }                   // edge
  const VoxelGrid<uint8_t>& carved() const { return carved_; }  // 1 inside, before the blur
  std::vector<ShapePoint> surface() const;                      // one for every voxel that it passes
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
