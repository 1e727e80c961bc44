// Depth, weight and colour maps for TSDF fusion, from a rendered view (algorithms 6.3).
//   depth   blended mean within 2 voxels of the median (a smooth surface), else the median (at an edge the mean would lie between
//           two surfaces); none where alpha < 0.5
//   weight  alpha max(0, N.v)^2 / z^2 where alpha > 0.7: near and frontal views are most accurate
#pragma once

#include <functional>
#include <vector>

#include "core/render/raster/raster_desc.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/mesh/tsdf_volume.h"
#include "core/scene/objects/object_labels.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

constexpr float kLeastDepthAlpha = 0.5f;  // pixels with less alpha have no depth

struct RgbdFrame {
  Intrinsics intrinsics;
  Rigid cam_from_world;
  std::vector<float> zdepth, weight;  // [h,w]
  std::vector<float> color;           // [3,h,w] linear, not premultiplied
  double valid_fraction = 0;          // fraction of pixels with a depth and a weight
  DepthView view() const { return {intrinsics, cam_from_world, zdepth, weight, color}; }
};

// `images` contains color, normal, zdepth, alpha and median_z of this view on a black background.
RgbdFrame rgbd_frame(const RasterImages& images, const Intrinsics& intrinsics, const Rigid& cam_from_world, double voxel);

// Fusion of all depth maps into one volume in bounded memory, one view at a time, in two rounds. The first round finds the blocks
// and is repeated with a larger voxel if they exceed the memory; the second round fuses.

struct FusionDesc {
  TsdfDesc volume;                     // with the requested voxel
  size_t max_bytes = size_t(1) << 30;  // of blocks
  double min_valid_fraction = 0.05;    // views with fewer usable pixels are skipped
};

struct FusionReport {
  double voxel = 0;  // actual voxel size
  size_t blocks = 0, bytes = 0, updates = 0;
  std::vector<size_t> skipped_views;
};

// Returns the depth map of view i for a given voxel size, which its mean/median rule depends on.
using DepthSource = std::function<RgbdFrame(size_t view, double voxel)>;

// `progress` receives a fraction in [0,1]; it may throw to interrupt. Throws Error{Input} when no view shows a surface.
TsdfVolume fuse_views(size_t view_count, const DepthSource& depth_of, const FusionDesc& desc,
                      const std::function<void(double)>& progress, FusionReport& report);

// Second mesh for content behind glass (mesh.ply ends at the panes because its depth is that of the first surface). Where a
// training view shows glass, the depth of the scene without glass (core/render/model/opened_scene.h) is fused inside the bounding
// boxes of the mesh's glass parts. Faces already in mesh.ply (a table that also extends outside) and faces on the panes are
// removed.

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

// Depth of mirrors from their shapes (core/scene/objects), optimised by training if available. Surfels of a mirror represent
// virtual images, with wrong depths and normals, and relighting of metal depends on exact normals. Coats keep the depth of their
// surfels: a glazed pot is hollow, its visual hull is not.

class MirrorDepth {
 public:
  // `learnt`: optimised shapes (ImageOptions::shape), or nullptr. `views`: the fused views, at their size.
  MirrorDepth(LabelledObjects objects, const ShapeSet* learnt, const std::vector<View>& views);

  bool empty() const { return shapes_.entries.empty(); }
  // Sets the depth of the shape in the mirror pixels of view i, unless the frame has a surface more than `tolerance` in front of
  // it. Mirror pixels outside the shape are not fused.
  void put(size_t i, RgbdFrame& frame, double tolerance) const;
  // Moves vertices within `tolerance` of an optimised shape onto it and gives them its normals, because voxel terraces are
  // visible in a mirror. Vertices on an appendage get its normals. Returns their number.
  size_t put_vertices(TriMesh& mesh, double tolerance) const;

 private:
  LabelledObjects objects_;
  std::vector<View> views_;
  ShapeSet shapes_;              // of mirrors
  std::vector<uint8_t> learnt_;  // [entry] optimised by training, including the tops of lids, which no silhouette shows
};

}  // namespace vitrine
