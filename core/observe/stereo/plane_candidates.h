// Candidate rectangles for masks, from two sources: masks that are quadrilaterals, and planes through sparse points near the
// masks.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/scene/shape/plane.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// Triangulates the four corners of a quadrilateral in one photo with those of one in another. Four points that form a rectangle
// are a candidate. Sorted by the number of photos (at least three) whose quadrilaterals have their corners there.
std::vector<Plane> candidates_of_outlines(std::span<const Silhouette> masks, double least_share);

// RANSAC planes (Fischler and Bolles 1981) of the sparse points that project into the masks, or next to them, in most photos; on
// each, the smallest rectangles around the area that most photos show inside. A point inside has the weight `inside_weight`, one
// next to a mask 1: points inside a mirror are virtual images.
std::vector<Plane> candidates_of_points(std::span<const Silhouette> masks, std::span<const Vec3d> points, double inside_weight);

}  // namespace vitrine
