// Second mesh for content behind glass (mesh.ply ends at the panes because its depth is that of the first surface). Where a
// training view shows glass, the depth of the scene without glass (core/render/model/opened_scene.h) is fused inside the bounding
// boxes of the mesh's glass parts. Faces already in mesh.ply (a table that also extends outside) and faces on the panes are
// removed.
#pragma once

#include <functional>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"
#include "stages/mesh/fusion.h"

namespace vitrine {

struct BehindGlassDesc {
  const TriMesh& mesh;        // mesh.ply
  const SplatLayer& diffuse;  // determines the glass faces of the mesh
  size_t views = 0;
  std::function<std::vector<uint8_t>(size_t view)> glass_of;  // [h,w] 1 = glass in the view
  DepthSource depth_of;                                       // of the scene without glass
  FusionDesc fusion{};                                        // as for the mesh; bounds are replaced
  double voxel = 0;                                           // of the mesh
  double min_component = 0.005;
  int smooth_iterations = 5;
  size_t faces = 50000;
};

// Empty without glass or without content behind it. With vertex normals.
TriMesh behind_glass(const BehindGlassDesc& desc, const std::function<void(double)>& progress);

}  // namespace vitrine
