// The visual hull of an object: what is left of space when every mask has cut away what it shows to be empty (Laurentini, "The
// visual hull concept for silhouette-based image understanding", 1994). For glass and mirrors, whose pixels no stereo matches, it
// is the only geometry that the photos give. It needs photos from around: seen from one side alone a hull is a cone to infinity.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/math/voxel_grid.h"
#include "core/stereo/box_fit.h"
#include "core/stereo/flat_faces.h"
#include "core/stereo/hull_mask.h"
#include "core/stereo/revolution_fit.h"

namespace vitrine {

struct HullDesc {
  int resolution = 128;     // voxels along the longest side of what is left
  double dissent = 0.1;     // share of the photos that may see a voxel outside their mask: something may stand in front
  size_t fewest_views = 3;  // photos that must see a voxel, at least
  int blur_passes = 3;      // of a 3-voxel box over the surface: a bell of sqrt(2/3 passes) voxels
  bool one_piece = false;   // keep the largest connected part: cones of few photos also meet where nothing is
  double reach = 1.2;       // half edge of the cube around the cameras' centre that is looked at
  // Where the masks are outlines of a box, the surface is the box; else normals are those of solids of revolution or, if there is
  // none, of flat faces, where it has such.
  bool flat_faces = false;
  double most_one_sided = 0.8;  // length of the mean direction towards the cameras; 1 = all look from one place
};

class VisualHull {
 public:
  VisualHull(std::span<const HullMask> masks, const HullDesc& desc);

  bool empty() const { return grid_.values.empty(); }
  double one_sidedness() const { return one_sidedness_; }                // of the cameras, as seen from the hull
  const Bounds3& bounds() const { return bounds_; }                      // of what is left, without the room around it
  size_t faces() const { return box_ ? 6 : faces_.size(); }              // flat ones that normals come from
  std::span<const SolidOfRevolution> solids() const { return turned_; }  // that pieces of it are, with HullDesc::flat_faces
  double voxel() const { return grid_.cell; }                            // edge
  std::vector<HullSurfacePoint> surface() const;                         // one for every voxel that it passes
  // First crossing of the smoothed surface, for t > 0. Thread-safe.
  std::optional<HullHit> first_hit(const Vec3d& origin, const Vec3d& direction) const;

 private:
  float occupancy(const Vec3d& p) const;  // trilinear, 0 outside
  Vec3d inwards(const Vec3d& p) const;    // gradient of the occupancy, times 3 voxels
  Bounds3 bounds_;
  VoxelGrid<float> grid_;  // occupancy, blurred
  double one_sidedness_ = 0;
  std::optional<Box> box_;
  std::vector<SolidOfRevolution> turned_;
  std::vector<FlatFace> faces_;
};

}  // namespace vitrine
