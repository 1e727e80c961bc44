// Surfaces of revolution whose silhouettes the masks are. The profile curve about the axis follows from the silhouettes of all
// photos at once, with normals as smooth as it is. A visual hull of the same masks is made of voxels and bulges between the
// cones. Appendages and handles are no part of it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/scene/shape/hit.h"
#include "core/scene/shape/surface_of_revolution.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// Of radii at equal heights along the axis, the first at `low`, with its two flat ends.
SurfaceOfRevolution revolved(const Vec3d& origin, const Vec3d& axis, double low, double step, std::span<const double> radii);

// One for each connected piece of a hull that lies on it for the most part. Axes start along z. Unknown pixels (value < 0) do not
// count, and a photo with something in front is outvoted.
std::vector<SurfaceOfRevolution> surfaces_of_revolution(std::span<const Silhouette> silhouettes,
                                                        std::span<const ShapePoint> surface, double voxel);

// 1 inside the silhouette of the surface, [h,w] of the view.
std::vector<uint8_t> silhouette_mask(const SurfaceOfRevolution& surface, const View& view);

}  // namespace vitrine
