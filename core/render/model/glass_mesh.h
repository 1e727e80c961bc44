// Glass part of an extracted mesh: the faces whose nearby diffuse surfels transmit light. Opaque objects behind or inside glass
// are closed surfaces as well; only glass faces define where a transmitted ray enters and leaves.
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
  float voxel = 0;  // edge of the voxels used for extraction, scene units
  MeshHits all;     // of the whole mesh
  MeshHits panes;   // of the glass

  // `voxel` > 0. The mesh may be empty.
  GlassMesh(const TriMesh& mesh, const SplatLayer& diffuse, float voxel);

 private:
  GlassMesh(const TriMesh& mesh, TriMesh glass_part, float voxel);
};

// Per face: 1 if the mean tau of nearby surfels, weighted by opacity and distance, exceeds 1/2. 0 without nearby surfels.
std::vector<uint8_t> glass_faces(const TriMesh& mesh, const SplatLayer& diffuse, float voxel);

}  // namespace vitrine
