#include "stages/mesh/fusion.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/log.h"

namespace vitrine {

namespace {

constexpr double kFirstRoundShare = 0.8;
constexpr double kGrowthSlack = 1.03;  // blocks fall a little slower than the square of the voxel: they are counted whole

}  // namespace

TsdfVolume fuse_views(size_t view_count, const DepthSource& depth_of, const FusionDesc& desc,
                      const std::function<void(double)>& progress, FusionReport& report) {
  report = {};
  TsdfDesc volume_desc = desc.volume;
  double done = 0;
  for (;;) {
    const double share = kFirstRoundShare * (0.5 - done);  // a repeated round advances within what is left of the half

    TsdfVolume volume(volume_desc);
    report.skipped_views.clear();
    std::vector<uint8_t> used(view_count, 0);
    for (size_t i = 0; i < view_count; ++i) {
      progress(done + share * static_cast<double>(i) / static_cast<double>(view_count));
      const RgbdFrame map = depth_of(i, volume_desc.voxel);
      used[i] = map.valid_fraction >= desc.min_valid_fraction;
      if (used[i])
        volume.touch(map.view());
      else
        report.skipped_views.push_back(i);
    }
    done += share;
    report.blocks = volume.touched_count();
    report.bytes = report.blocks * TsdfVolume::bytes_per_block();
    if (report.blocks == 0)
      throw Error(ErrorKind::Input, "no view shows a surface inside the region of the mesh",
                  {.why = fmt::format("{} of {} views have less than {:.0f} % usable pixels", report.skipped_views.size(),
                                      view_count, 100 * desc.min_valid_fraction),
                   .hint = "look at optimize/previews; if they are fine, set mesh.region.box",
                   .code = "NO_SURFACE"});
    if (report.bytes > desc.max_bytes) {
      const double growth = kGrowthSlack * std::sqrt(static_cast<double>(report.bytes) / static_cast<double>(desc.max_bytes));
      log_debug("mesh: {} blocks do not fit, voxel {:.5f} -> {:.5f}", report.blocks, volume_desc.voxel,
                volume_desc.voxel * growth);
      volume_desc.voxel *= growth;
      continue;
    }
    report.voxel = volume_desc.voxel;
    volume.allocate();
    for (size_t i = 0; i < view_count; ++i) {
      progress(0.5 + 0.5 * static_cast<double>(i) / static_cast<double>(view_count));
      if (used[i]) report.updates += volume.integrate(depth_of(i, volume_desc.voxel).view());
    }
    return volume;
  }
}

}  // namespace vitrine
