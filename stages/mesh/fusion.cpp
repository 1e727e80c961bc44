#include "stages/mesh/fusion.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr float kFusedAlpha = 0.7f;      // pixels with no more have a depth, but are not fused
constexpr double kMeanMedianVoxels = 2;  // the mean depth is used within this distance of the median

constexpr double kFirstRoundShare = 0.8;
constexpr double kGrowthSlack = 1.03;  // rounds up: blocks shrink slightly slower than with the square of the voxel

}  // namespace

RgbdFrame rgbd_frame(const RasterImages& images, const Intrinsics& intrinsics, const Rigid& cam_from_world, double voxel) {
  const size_t w = static_cast<size_t>(intrinsics.width), h = static_cast<size_t>(intrinsics.height), pixels = w * h;
  const auto color = images.plane(Aov::Color), normal = images.plane(Aov::Normal), zsum = images.plane(Aov::ZDepth);
  const auto alpha = images.plane(Aov::Alpha), median = images.plane(Aov::MedianZ);
  VITRINE_CHECK(color.size() == 3 * pixels && normal.size() == 3 * pixels && zsum.size() == pixels && alpha.size() == pixels &&
                    median.size() == pixels,
                "a depth map needs colour, normal, zdepth, alpha and median_z");
  RgbdFrame map{intrinsics,
                cam_from_world,
                std::vector<float>(pixels, 0.f),
                std::vector<float>(pixels, 0.f),
                std::vector<float>(3 * pixels, 0.f),
                0};
  const float tolerance = float(kMeanMedianVoxels * voxel);
  const Mat3f rotation = cast<float>(cam_from_world.rotation);
  std::vector<size_t> valid(h, 0);
  parallel_for(h, 16, [&](size_t y) {
    for (size_t x = 0; x < w; ++x) {
      const size_t p = y * w + x;
      const float a = alpha[p];
      if (!(a >= kLeastDepthAlpha)) continue;
      const float mean = zsum[p] / a;
      const float z = std::abs(mean - median[p]) < tolerance ? mean : median[p];
      if (!(z > 0.f) || !std::isfinite(z)) continue;
      map.zdepth[p] = z;
      for (size_t c = 0; c < 3; ++c) map.color[c * pixels + p] = color[c * pixels + p] / a;
      if (!(a > kFusedAlpha)) continue;
      const Vec3f n{normal[p], normal[pixels + p], normal[2 * pixels + p]};
      const float len = length(n);
      if (!(len > 0.f)) continue;
      const Vec3f ray = transposed_times(rotation, cast<float>(intrinsics.ray(double(x) + 0.5, double(y) + 0.5)));
      const float cosine = std::max(0.f, -dot(n, ray) / (len * length(ray)));
      map.weight[p] = a * cosine * cosine / (z * z);
      valid[y] += map.weight[p] > 0.f;
    }
  });
  size_t total = 0;
  for (size_t v : valid) total += v;
  map.valid_fraction = static_cast<double>(total) / static_cast<double>(pixels);
  return map;
}

TsdfVolume fuse_views(size_t view_count, const DepthSource& depth_of, const FusionDesc& desc,
                      const std::function<void(double)>& progress, FusionReport& report) {
  report = {};
  TsdfDesc volume_desc = desc.volume;
  double done = 0;
  for (;;) {
    const double share = kFirstRoundShare * (0.5 - done);  // a repeated round reports progress within the rest of its half

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
