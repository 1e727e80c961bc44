// The sum of 3D Gaussians at the centres of a grid's cells, forward and reverse, for pictures of slices, iso surfaces and losses
// on the field. Gaussians end at kVolumeCutoff standard deviations (line_integrals.h). Same bytes for any number of threads.
#pragma once

#include <span>

#include "core/foundation/math/voxel_grid.h"
#include "core/render/volume/gaussian3.h"

namespace vitrine {

// Overwrites grid.values [z][y][x] with densities, 1 / scene unit.
void sample_density(std::span<const Gaussian3f> gaussians, VoxelGrid<float>& grid);
// Adds the gradient for dL/d(density) of every cell: `gradient` has the geometry of the sampled grid.
void sample_density_vjp(std::span<const Gaussian3f> gaussians, const VoxelGrid<float>& gradient,
                        std::span<Gaussian3Gradient> out);

}  // namespace vitrine
