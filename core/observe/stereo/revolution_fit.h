// Fits surfaces of revolution to masks. The profile about the axis follows from the silhouettes of all photos jointly and has
// smooth normals; a visual hull of the same masks has voxel steps and bulges between the viewing cones. Handles and other
// appendages are excluded.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/shape/hit.h"
#include "core/scene/shape/surface_of_revolution.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// Surface from radii at equal steps along the axis, the first at `low`, with two flat ends.
SurfaceOfRevolution revolved(const Vec3d& origin, const Vec3d& axis, double low, double step, std::span<const double> radii);

// One surface for each connected component of a visual hull that mostly lies on it. The axis search starts along z. Unknown
// pixels (value < 0) do not count; photos in which the object is occluded are outliers.
std::vector<SurfaceOfRevolution> surfaces_of_revolution(std::span<const Silhouette> silhouettes,
                                                        std::span<const ShapePoint> surface, double voxel);

// 1 inside the silhouette of the surface, [h,w] of the view.
std::vector<uint8_t> silhouette_mask(const SurfaceOfRevolution& surface, const View& view);

}  // namespace vitrine
