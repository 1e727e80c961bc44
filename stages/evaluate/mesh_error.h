// Our mesh against the truth's, in the truth's frame: accuracy (our samples -> truth), completeness (truth samples -> ours),
// their mean (chamfer), and precision, recall, F-score at a distance threshold. Lengths are relative to the diagonal of the truth
// mesh's bounding box. Only what the photos can know counts (README, "Which samples count"):
//   truth sample: the truth's surface at its place is the first one in at least 2 views, outside the transparent mask;
//   our sample:   visible on our own mesh in at least 2 views, and most of the views that see it look, at this pixel, at an
//                 opaque surface of the truth mesh, so that a room the truth mesh leaves out is neither praised nor blamed.
#pragma once

#include <functional>
#include <vector>

#include "core/scene/camera/projection.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

// A view in the truth's frame, for visibility.
struct MeshView {
  Intrinsics intrinsics;
  Rigid cam_from_world;
  ImageF zdepth;       // the truth's first surface, glass included; empty when there is no depth map
  ImageF transparent;  // 0 or 1; empty when there is no mask
};

struct MeshErrorDesc {
  size_t samples = 100'000;  // per mesh
  double threshold_rel = 0.01;
  double depth_tolerance_rel = 0.01;  // two depths within this fraction are one surface
  int min_views = 2;
  uint64_t seed = 1;
};

struct MeshError {
  double accuracy_rel = 0, completeness_rel = 0, chamfer_rel = 0;  // means of distances
  double accuracy_median_rel = 0, completeness_median_rel = 0;
  double precision = 0, recall = 0, fscore = 0;
  double diagonal = 0;                        // truth units
  size_t our_samples = 0, truth_samples = 0;  // that count
};

// `ours` already in the truth's frame. `first_surface` = the truth mesh with its glass (may be the same mesh): stands in for
// views without a depth map. Views are made on demand, so that one is in memory at a time.
MeshError mesh_error(const TriMesh& ours, const TriMesh& truth, const TriMesh& first_surface, size_t view_count,
                     const std::function<MeshView(size_t)>& view, const MeshErrorDesc& desc = {});

TriMesh transformed(const TriMesh& mesh, const Similarity& new_from_old);  // positions only

// z-depth of a triangle mesh in one view, by scan conversion: what is the first surface at a pixel, and is a point hidden?
// One sample per pixel centre; 1/z is linear on the screen; triangles are clipped at the near plane.
// One channel, camera z; 0 where no triangle is.
ImageF mesh_zdepth(const TriMesh& mesh, const Intrinsics& intrinsics, const Rigid& cam_from_world);

// Whether a surface at camera depth p.z can be the one that `zdepth` shows around p: one of the four nearest samples agrees
// to `tolerance_rel` of its depth.
bool agrees_with(const ImageF& zdepth, const ImagePoint& p, double tolerance_rel);

}  // namespace vitrine
