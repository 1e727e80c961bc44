// Mesh error in the truth frame: accuracy (our samples -> truth), completeness (truth samples -> ours), their mean (chamfer), and
// precision, recall and F-score at a distance threshold. Lengths are relative to the diagonal of the truth mesh's bounding box.
// Only surfaces visible in the photos count (README, "Which samples count"):
//   truth sample: the first truth surface in at least 2 views, outside the transparent mask;
//   our sample:   visible on our mesh in at least 2 views, and most of these views see an opaque truth surface at this pixel, so
//                 that a room missing in the truth mesh does not affect the score.
#pragma once

#include <functional>
#include <vector>

#include "core/scene/camera/projection.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

// A view in the truth frame, for visibility.
struct MeshView {
  Intrinsics intrinsics;
  Rigid cam_from_world;
  ImageF zdepth;       // the first truth surface, including glass; empty without a depth map
  ImageF transparent;  // 0 or 1; empty without a mask
};

struct MeshErrorDesc {
  size_t samples = 100'000;  // per mesh
  double threshold_rel = 0.01;
  double depth_tolerance_rel = 0.01;  // relative depth tolerance of one surface
  int min_views = 2;
  uint64_t seed = 1;
};

struct MeshError {
  double accuracy_rel = 0, completeness_rel = 0, chamfer_rel = 0;  // mean distances
  double accuracy_median_rel = 0, completeness_median_rel = 0;
  double precision = 0, recall = 0, fscore = 0;
  double diagonal = 0;                        // truth units
  size_t our_samples = 0, truth_samples = 0;  // counted samples
};

// `ours` is in the truth frame. `first_surface` = the truth mesh with its glass (may be the same mesh), for views without a depth
// map. Views are created on demand, one in memory at a time.
MeshError mesh_error(const TriMesh& ours, const TriMesh& truth, const TriMesh& first_surface, size_t view_count,
                     const std::function<MeshView(size_t)>& view, const MeshErrorDesc& desc = {});

TriMesh transformed(const TriMesh& mesh, const Similarity& new_from_old);  // positions only

// z-depth of a triangle mesh in one view by scan conversion, for the first surface per pixel and for occlusion tests. One sample
// per pixel centre; 1/z is linear in screen space; triangles are clipped at the near plane. One channel, camera z; 0 = no
// triangle.
ImageF mesh_zdepth(const TriMesh& mesh, const Intrinsics& intrinsics, const Rigid& cam_from_world);

// True if a surface at camera depth p.z matches `zdepth` at p: one of the four nearest samples is within `tolerance_rel` of its
// depth.
bool agrees_with(const ImageF& zdepth, const ImagePoint& p, double tolerance_rel);

}  // namespace vitrine
