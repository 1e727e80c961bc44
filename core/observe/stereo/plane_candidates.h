// Rectangles that may be the things that masks mark, from two sources: quadrilaterals that the masks are, and planes through
// sparse points about the masks.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/scene/shape/plane.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// The four corners of a quadrilateral in one photo and of one in another are four points of space where the rays through them
// meet; where these are the corners of a rectangle, it is a candidate. Those come first whose corners lie on those of
// quadrilaterals in the most photos (at least three).
std::vector<Plane> candidates_of_outlines(std::span<const Silhouette> masks, double least_share);

// Planes by RANSAC (Fischler and Bolles 1981) of the points that project into the masks, or beside them, in most photos; on each
// the rectangles of least area around what most photos show inside. A point inside weighs `inside_weight`, one beside it 1:
// behind a mirror points are those of virtual images.
std::vector<Plane> candidates_of_points(std::span<const Silhouette> masks, std::span<const Vec3d> points, double inside_weight);

}  // namespace vitrine
