// Depth, weight and colour maps for TSDF fusion, from a rendered view (algorithms 6.3).
//   depth   blended mean within 2 voxels of the median (a smooth surface), else the median (at an edge the mean would lie between
//           two surfaces); none where alpha < 0.5
//   weight  alpha max(0, N.v)^2 / z^2 where alpha > 0.7: near and frontal views are most accurate
#pragma once

#include <functional>
#include <vector>

#include "core/scene/mesh/tsdf_volume.h"
#include "core/render/raster/raster_desc.h"

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

}  // namespace vitrine
