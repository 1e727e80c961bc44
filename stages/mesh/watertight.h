// Closed mesh for printing, volumes and simulation (algorithms 6.5). Points spread evenly over the fused mesh, with the normals
// of its faces, which look to the cameras, give a Poisson surface (core/scene/mesh/poisson_cgal.h). It is cleaned, smoothed and
// decimated like the fused mesh; a step that opens it is left out. Where no photo looked, as below an object on a table, the
// surface is invented; colours there are those of the nearest fused surface.
#pragma once

#include <cstddef>
#include <functional>

#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/poisson_cgal.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct WatertightDesc {
  double voxel = 0;        // of the fusion, scene units: at most one point per square voxel
  size_t faces = 200000;   // of the result; at most one point per two faces
  ComponentRule pieces{};  // which parts are kept
  int smooth_iterations = 5;
};

struct WatertightReport {
  PoissonReport poisson;
  MeshReport fused;           // of the input
  double to_fused = 0;        // mean distance of the closed mesh from the fused one, scene units
  double from_fused = 0;      // mean distance of the fused mesh from the closed one, scene units
  double invented_share = 0;  // of the area, farther than kInventedVoxels voxels from the fused mesh
};
inline constexpr double kInventedVoxels = 3;

// With normals and, if `fused` has them, colours; faces look to the cameras as those of `fused` do. `progress` receives a
// fraction in [0,1]; it may throw to interrupt. Throws Error{Input} with code NOT_CLOSED.
TriMesh watertight(const TriMesh& fused, const WatertightDesc& desc, const std::function<void(double)>& progress,
                   WatertightReport& report);

// Handles of all components together, holes counted as closed: (2 components - boundary loops - Euler characteristic) / 2.
int64_t genus_of(const MeshReport& mesh);

}  // namespace vitrine
