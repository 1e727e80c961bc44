// The rectangles whose silhouettes the masks are: windows, pictures under glass, mirrors on walls. Seen from one side they have
// no closed visual hull; but two photos of its corners fix a rectangle, and the silhouettes of all photos refine its eight
// numbers.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/scene/shape/plane.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

// Measured: true ones behind things .915 and more; a ball .85, others that were tried .87.
inline constexpr double kLeastPlaneAgreement = 0.9;

struct PlaneFit {
  Plane plane;           // its front faces the cameras
  double agreement = 0;  // intersection over union of silhouettes and masks: mean over the better three quarters of the photos
};

struct PlaneFitDesc {
  double inside_weight = 1;  // of a sparse point inside the masks; one beside them counts 1
  double least = kLeastPlaneAgreement;
  bool one_sided = false;  // none that photos from behind see as well: those are of closed objects, or stand freely
};

// Those that agree to `least`, the best supported first; a ball is none, and no object that a box fits
// clearly better. Pixels with mask < 0 do not count; a photo with
// something in front of the rectangle is outvoted. `points`: sparse ones, may be none.
std::vector<PlaneFit> fit_planes(std::span<const Silhouette> masks, std::span<const Vec3d> points, const PlaneFitDesc& desc);

// The rectangle near `start` with the best agreement; nullopt where too few photos show it, or less than `least` agree.
std::optional<PlaneFit> refined_plane(std::span<const Silhouette> masks, const Plane& start, double least);

}  // namespace vitrine
