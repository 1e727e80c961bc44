// Which parts of an extracted mesh are glass: the faces around which the diffuse layer's surfels let light through. Opaque things
// behind or inside glass are closed shells as well; only those of glass say where a transmitted ray enters and leaves.
#pragma once

#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"
#include "core/scene/mesh/mesh_hits.h"

namespace vitrine {

struct GlassMesh {
  TriMesh glass;                 // the faces of glass
  std::vector<uint32_t> region;  // [faces of glass] connected pieces, numbered by size, the largest first
  size_t regions = 0;
  float voxel = 0;  // edge of the voxels that the mesh was made from, scene units
  MeshHits all;     // of the whole mesh
  MeshHits panes;   // of the glass

  // `voxel` > 0. The mesh may have no face at all.
  GlassMesh(const TriMesh& mesh, const SplatLayer& diffuse, float voxel);

 private:
  GlassMesh(const TriMesh& mesh, TriMesh glass_part, float voxel);
};

// Per face: the mean tau of the surfels around its centre, by opacity and distance, is above 1/2. Without a surfel near: 0.
std::vector<uint8_t> glass_faces(const TriMesh& mesh, const SplatLayer& diffuse, float voxel);

}  // namespace vitrine
