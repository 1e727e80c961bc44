// Voxels fitted to projections: the simultaneous algebraic technique in at most 38 steps a round (SART: Andersen and Kak 1984;
// ordered subsets: Hudson and Larkin 1994), and after each round a step towards smaller total variation.
#pragma once

#include <filesystem>
#include <functional>
#include <span>

#include "core/scene/image/image.h"
#include "stages/tomography/scan_geometry.h"

namespace vitrine {

struct VoxelFitDesc {
  int rounds = 5;     // each fits every projection once; their steps fall to a tenth
  double tv = 0.015;  // weight of the total variation: the jump that the first round removes, as a share of the dense voxels
  // Written after each round and on an interrupt; where the file exists, the fit goes on from it. Empty: none.
  std::filesystem::path checkpoint = {};
};

struct FitRound {
  int round = 0;     // from 1
  double share = 0;  // of its projections that are fitted
  double error = 0;  // root mean square of their differences before their steps, line integrals
};

// Overwrites the values of `grid` with densities of at least 0, 1 / unit of length. `progress` after each step. Same bytes for
// any number of threads and of interruptions.
void fit_voxels(const ScanGeometry& g, std::span<const ImageF> projections, VoxelGrid<float>& grid, const VoxelFitDesc& desc,
                const std::function<void(const FitRound&)>& progress = {});

// Line integrals of the voxels in every view, trilinear between their middles.
std::vector<ImageF> projected(const ScanGeometry& g, const VoxelGrid<float>& grid);

// Value of one channel at a place in pixels, 0 beyond the border pixels' middles by more than a pixel.
double bilinear(const ImageF& image, double px, double py);

// Bytes of the fit and of its checkpoint, without the projections.
size_t voxel_fit_bytes(const VoxelGrid<float>& grid);

}  // namespace vitrine
