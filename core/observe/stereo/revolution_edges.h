// Fits a solid of revolution to photo edges. Masks found in each photo separately miss the silhouette where a mirror object
// looks like its background. The silhouette lies in all photos on the same profile about the same axis; edges of reflections do
// not.
#pragma once

#include <span>

#include "core/observe/stereo/edge_field.h"
#include "core/observe/stereo/revolution_fit.h"

namespace vitrine {

// `start` with the axis and the radii that maximise the contrast across its silhouette over all photos; `start` itself where
// fewer than five photos show it. Radii move by less than a quarter of the largest one. Where the surface faces mostly up or
// down, as on lids and feet, whose rims are edges as well, they move with the neighbouring radii.
SurfaceOfRevolution drawn_to_edges(const SurfaceOfRevolution& start, std::span<const EdgePhoto> photos);

}  // namespace vitrine
