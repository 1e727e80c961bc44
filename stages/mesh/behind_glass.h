// What stands behind glass. The fused depth is that of the first surface, so mesh.ply ends at the panes; what is in a case is in
// this second mesh. Where a training view shows glass, the depth of everything but the glass (core/render/model/opened_scene.h) is
// fused inside the boxes of the mesh's glass parts; faces that mesh.ply has already (a table that also goes on outside) and those
// that lie on the panes themselves are left out.
#pragma once

#include <functional>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"
#include "stages/mesh/fusion.h"

namespace vitrine {

struct BehindGlassDesc {
  const TriMesh& mesh;        // mesh.ply
  const SplatLayer& diffuse;  // tells which of its faces are glass
  size_t views = 0;
  std::function<std::vector<uint8_t>(size_t view)> glass_of;  // [h,w] 1 where the view shows glass
  DepthSource depth_of;                                       // of everything but the glass
  FusionDesc fusion{};                                        // as the mesh's own; bounds are chosen here
  double voxel = 0;                                           // that the mesh was made with
  double min_component = 0.005;
  int smooth_iterations = 5;
  size_t faces = 50000;
};

// Empty without glass, or when nothing is there. With vertex normals.
TriMesh behind_glass(const BehindGlassDesc& desc, const std::function<void(double)>& progress);

}  // namespace vitrine
