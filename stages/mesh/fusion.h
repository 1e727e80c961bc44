// All depth maps into one volume, in bounded memory: one view at a time, twice. The first round finds the blocks; when they
// would not fit, the voxel grows and the round is repeated; the second round fuses.
#pragma once

#include <functional>
#include <vector>

#include "core/mesh/tsdf_volume.h"
#include "stages/mesh/rgbd_frame.h"

namespace vitrine {

struct FusionDesc {
  TsdfDesc volume;                     // with the wanted voxel
  size_t max_bytes = size_t(1) << 30;  // of blocks
  double min_valid_fraction = 0.05;    // views with fewer usable pixels are skipped
};

struct FusionReport {
  double voxel = 0;  // as used
  size_t blocks = 0, bytes = 0, updates = 0;
  std::vector<size_t> skipped_views;
};

// The depth map of view i, for a given voxel (its mean/median rule depends on it).
using DepthSource = std::function<RgbdFrame(size_t view, double voxel)>;

// `progress` gets a fraction in [0,1]; it may throw to interrupt. Throws Error{Input} when no view shows a surface.
TsdfVolume fuse_views(size_t view_count, const DepthSource& depth_of, const FusionDesc& desc,
                      const std::function<void(double)>& progress, FusionReport& report);

}  // namespace vitrine
