// Filtered backprojection: parallel beams by the ramp filter, cone beams by Feldkamp, Davis and Kress (1984). What the
// fit is compared with.
#pragma once

#include <span>

#include "core/scene/image/image.h"
#include "stages/tomography/scan_geometry.h"

namespace vitrine::test {

// Radians that each angle stands for: half the way to its neighbours, at most twice the median; their sum is pi (parallel beams,
// where opposite views are the same) or 2 pi (cone beams).
std::vector<double> angle_weights(const ScanGeometry& g);

// Overwrites the values of `grid` with densities, 1 / unit of length. `projections`: line integrals, one channel, in the order of
// the angles. Negative values stay.
void filtered_backprojection(const ScanGeometry& g, std::span<const ImageF> projections, VoxelGrid<float>& grid);

}  // namespace vitrine::test
