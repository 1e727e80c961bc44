#include "core/render/raster/blocks/device_host.h"

#include <algorithm>
#include <cmath>

namespace vitrine::blocks {

BlockView block_view(const RasterDesc& desc, int layer_degree) {
  const Intrinsics& k = desc.intrinsics;
  const Rigid& pose = desc.cam_from_world;
  BlockView v{};
  v.camera = {F32(k.fx),
              F32(k.fy),
              F32(k.cx),
              F32(k.cy),
              cast<F32>(pose.rotation),
              cast<F32>(pose.translation),
              cast<F32>(inverse(pose).translation)};
  v.near_z = desc.near_z;
  v.far_z = desc.far_z;
  v.low_pass = static_cast<float>(desc.low_pass ? kLowPassInvVariance : kNoLowPass);
  for (size_t c = 0; c < 3; ++c) v.background[c] = desc.background[c];
  v.width = k.width;
  v.height = k.height;
  v.tiles_x = (k.width + BlockView::kTileSide - 1) / BlockView::kTileSide;
  v.tiles_y = (k.height + BlockView::kTileSide - 1) / BlockView::kTileSide;
  v.sh_degree = std::min(desc.sh_degree, layer_degree);
  return v;
}

DeviceWork DeviceLoad::work() const {
  // The share: of the surfels times the pixels, by estimate.
  const auto smaller = [load = *this](double share) {
    const double side = std::sqrt(share);
    return fmt::format("{:.0f} surfels, or a picture of {:.0f} x {:.0f}, may fit; or --device cpu",
                       share * static_cast<double>(load.surfels), side * load.width, side * load.height);
  };
  return {"the picture", fmt::format("{} surfels, {} x {} pixels", surfels, width, height), smaller};
}

}  // namespace vitrine::blocks
