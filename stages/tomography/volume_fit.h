// 3D Gaussians fitted to projections: started from a filtered backprojection, optimised with Adam on the squared error of the
// line integrals plus the total variation of the sampled field.
#pragma once

#include <functional>
#include <span>

#include "core/render/volume/gaussian3.h"
#include "core/scene/image/image.h"
#include "stages/tomography/scan_geometry.h"

namespace vitrine {

struct VolumeFitDesc {
  int iterations = 600;  // projections that are fitted, one a step
  double spacing = 2;    // of the Gaussians at the start, voxels
  double tv = 0.05;      // weight of the total variation, relative to the squared error
  uint64_t seed = 1;     // of the order of the projections
};

struct FitStep {
  int step = 0;
  double error = 0;  // root mean square of this projection's difference
};

// A lattice of Gaussians where the backprojection is denser than a twentieth of its densest places; together they have its
// density, smoothed.
std::vector<Gaussian3f> gaussians_of(const VoxelGrid<float>& backprojection, double spacing);

// `grid`: geometry of the volume; its cell is the unit of the steps. Deterministic for any number of threads.
std::vector<Gaussian3f> fit_volume(const ScanGeometry& g, std::span<const ImageF> projections, const VoxelGrid<float>& grid,
                                   std::vector<Gaussian3f> gaussians, const VolumeFitDesc& desc,
                                   const std::function<void(const FitStep&)>& progress = {});

// Line integrals of the Gaussians in every view.
std::vector<ImageF> projected(const ScanGeometry& g, std::span<const Gaussian3f> gaussians);

}  // namespace vitrine
