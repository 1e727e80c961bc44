// A solid of revolution, put on the edges of the photos. Masks that were found in the photos one by one leave its silhouette
// where what it mirrors looks like what is behind it; but an silhouette is in all photos on the same curve, turned about the same
// axis, and mirrored edges are not.
#pragma once

#include <span>

#include "core/observe/stereo/edge_field.h"
#include "core/observe/stereo/revolution_fit.h"

namespace vitrine {

// `start` with the axis and the radii at which the photos together change most across its silhouette; `start` itself where fewer
// than five photos show it. Radii move by less than a quarter of the largest one, and where the surface looks far up or down, as
// on lids and feet, whose rims are edges as well, with those beside it.
SurfaceOfRevolution drawn_to_edges(const SurfaceOfRevolution& start, std::span<const EdgePhoto> photos);

}  // namespace vitrine
