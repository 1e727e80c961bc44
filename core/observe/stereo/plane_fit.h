// Fits rectangles to masks: windows, pictures under glass, mirrors on walls. Seen from one side they have no closed visual hull,
// but their corners in two photos define a rectangle, and the silhouettes of all photos refine its eight parameters.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/observe/stereo/silhouette.h"
#include "core/scene/shape/plane.h"

namespace vitrine {

// Measured IoU: true rectangles behind occluders .915 and more; a ball .85, other false candidates .87.
inline constexpr double kLeastPlaneAgreement = 0.9;

struct PlaneFit {
  Plane plane;           // its front faces the cameras
  double agreement = 0;  // IoU of silhouettes and masks: mean over the best three quarters of the photos
};

struct PlaneFitDesc {
  double inside_weight = 1;  // weight of a sparse point inside the masks; one next to them has 1
  double least = kLeastPlaneAgreement;
  bool one_sided = false;  // reject rectangles that photos from behind see equally well: closed objects, free-standing panels
};

// Rectangles with an IoU of at least `least`, the best supported first. Rejects balls and objects that a box fits clearly better.
// Pixels with mask < 0 do not count; photos in which the rectangle is occluded are outliers. `points`: sparse points, may be
// empty.
std::vector<PlaneFit> fit_planes(std::span<const Silhouette> masks, std::span<const Vec3d> points, const PlaneFitDesc& desc);

// Maximises the IoU from `start`; nullopt where too few photos show it, or the IoU stays below `least`.
std::optional<PlaneFit> refined_plane(std::span<const Silhouette> masks, const Plane& start, double least);

// Candidate rectangles for masks, from two sources: masks that are quadrilaterals, and planes through sparse points near the
// masks.

// Triangulates the four corners of a quadrilateral in one photo with those of one in another. Four points that form a rectangle
// are a candidate. Sorted by the number of photos (at least three) whose quadrilaterals have their corners there.
std::vector<Plane> candidates_of_outlines(std::span<const Silhouette> masks, double least_share);

// RANSAC planes (Fischler and Bolles 1981) of the sparse points that project into the masks, or next to them, in most photos; on
// each, the smallest rectangles around the area that most photos show inside. A point inside has the weight `inside_weight`, one
// next to a mask 1: points inside a mirror are virtual images.
std::vector<Plane> candidates_of_points(std::span<const Silhouette> masks, std::span<const Vec3d> points, double inside_weight);

}  // namespace vitrine
