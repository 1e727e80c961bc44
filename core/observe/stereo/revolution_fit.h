// Fits surfaces of revolution to masks. The profile about the axis follows from the silhouettes of all photos jointly and has
// smooth normals; a visual hull of the same masks has voxel steps and bulges between the viewing cones. Handles and other
// appendages are excluded.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/pattern_search.h"
#include "core/foundation/math/rigid.h"
#include "core/observe/stereo/edge_field.h"
#include "core/observe/stereo/silhouette.h"
#include "core/scene/shape/hit.h"
#include "core/scene/shape/surface_of_revolution.h"

namespace vitrine {

// Surface from radii at equal steps along the axis, the first at `low`, with two flat ends.
SurfaceOfRevolution revolved(const Vec3d& origin, const Vec3d& axis, double low, double step, std::span<const double> radii);

// One surface for each connected component of a visual hull that mostly lies on it. The axis search starts along z. Unknown
// pixels (value < 0) do not count; photos in which the object is occluded are outliers.
std::vector<SurfaceOfRevolution> surfaces_of_revolution(std::span<const Silhouette> silhouettes,
                                                        std::span<const ShapePoint> surface, double voxel);

// 1 inside the silhouette of the surface, [h,w] of the view.
std::vector<uint8_t> silhouette_mask(const SurfaceOfRevolution& surface, const View& view);

// Rotation axis of a solid of revolution and its pattern search, shared by the fits to masks and to photo edges.
struct TurningAxis {
  Vec3d origin, along, u, v;  // u, v: perpendicular to it, orthonormal
};
inline TurningAxis turning_axis(const Vec3d& origin, double tilt_x, double tilt_y) {
  const Vec3d along = normalized(Vec3d{tilt_x, tilt_y, 1});
  const Vec3d u = normalized(Vec3d{along.z, 0, -along.x});
  return {origin, along, u, cross(along, u)};
}

using AxisPlace = std::array<double, 4>;  // x and y of its origin, tilt towards x and y in radians

// Pattern search over the axis that maximises `score`: its origin alone or, with all four `numbers`, its tilt as well. Steps
// start at `first_move`, in units of `size` for the origin and in radians for the tilt.
template <class Score>
void improve_axis(double size, double first_move, double last_move, size_t numbers, const Score& score, AxisPlace& place) {
  static constexpr std::array<size_t, 4> kAll{0, 1, 2, 3};
  const auto move = [size](AxisPlace p, size_t i, double step) {
    p[i] += step * (i < 2 ? size : 1.0);
    return std::optional(p);
  };
  pattern_search(score, move, {first_move, last_move, true}, std::span(kAll).first(numbers), place);
}

// Fits a solid of revolution to photo edges. Masks found in each photo separately miss the silhouette where a mirror object
// looks like its background. The silhouette lies in all photos on the same profile about the same axis; edges of reflections do
// not.

// `start` with the axis and the radii that maximise the contrast across its silhouette over all photos; `start` itself where
// fewer than five photos show it. Radii move by less than a quarter of the largest one. Where the surface faces mostly up or
// down, as on lids and feet, whose rims are edges as well, they move with the neighbouring radii.
SurfaceOfRevolution drawn_to_edges(const SurfaceOfRevolution& start, std::span<const EdgePhoto> photos);

}  // namespace vitrine
