// Filter for the triangulated points that initialise the scene: small reprojection error, enough views, enough parallax, and no
// isolated points (mean distance to the eight nearest points, an outlier test on a log scale).
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

struct FilterCounts {
  size_t before = 0, large_error = 0, few_views = 0, small_angle = 0, behind = 0, lonely = 0, after = 0;
};

ColmapModel filtered(const ColmapModel& model, FilterCounts& counts);

// Largest angle between two viewing rays of the track, radians.
double triangulation_angle(const ColmapPoint3D& point, const std::vector<Vec3d>& centres_of_track);
// Mean distance to the `k` nearest other points.
std::vector<double> neighbour_distances(std::span<const Vec3d> points, size_t k);
// Indices of the k nearest other points of every point, nearest first.
std::vector<std::vector<uint32_t>> neighbours(std::span<const Vec3d> points, size_t k);

}  // namespace vitrine
