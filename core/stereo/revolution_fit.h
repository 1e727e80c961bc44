// Solids of revolution whose silhouettes the masks are: vases, bottles and bowls are turned about an axis, and the curve
// that is turned follows from the silhouettes of all photos at once, with normals as smooth as it is. A visual hull of the same
// masks is made of voxels and bulges between the cones. Appendages and handles are no part of it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/shape/surface_of_revolution.h"
#include "core/stereo/flat_faces.h"
#include "core/stereo/silhouette.h"

namespace vitrine {

struct SolidOfRevolution {
  Vec3d origin, axis;         // a point of the axis, its unit direction
  double low = 0, step = 0;   // height above `origin` of the first radius; from one to the next
  std::vector<double> radii;  // at least two, all positive; flat ends
  double top() const { return low + step * double(radii.size() - 1); }

  // The point of the surface nearest to `p`, with its normal: those of the profile's corners, blended between them.
  ShapePoint nearest(const Vec3d& p) const;
  // Where a point of a hull of such voxels, which bulges and wavers around the solid, should lie; nothing for other points: of a
  // appendage, a handle, the table.
  std::optional<ShapePoint> smoothed(const ShapePoint& p, double voxel) const;
  // Where a ray meets it first, in units of `direction`; 0 from within.
  std::optional<double> entry(const Vec3d& eye, const Vec3d& direction) const;
};

// With its two flat ends.
SurfaceOfRevolution surface_of_revolution(const SolidOfRevolution& solid);

// One for each connected piece of a hull that lies on it for the most part. Axes start along z. What the photos do not say
// (mask < 0) does not count, and a photo with something in front is outvoted.
std::vector<SolidOfRevolution> solids_of_revolution(std::span<const Silhouette> masks, std::span<const ShapePoint> surface,
                                                    double voxel);

// 1 inside the silhouette of the solid, [h,w] of the view.
std::vector<uint8_t> silhouette_mask(const SolidOfRevolution& solid, const View& view);

// On the first of the solids that have it.
std::optional<ShapePoint> on_solid(std::span<const SolidOfRevolution> solids, const ShapePoint& p, double voxel);

}  // namespace vitrine
