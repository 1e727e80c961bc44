// What the masks stage marks in a photo, put together for the decomposition: glass and mirrors do not speak about the light, and
// polished metal is where there is a mirror without glass.
#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "core/camera/view.h"
#include "core/image/image.h"

namespace vitrine {

struct MarkedPixels {
  std::optional<std::filesystem::path> masks;  // artifact of the masks stage
  std::span<const View> photos;                // at full size

  // One channel in [0, 1] at the size of `k`, of a photo at whatever size; empty: nothing is marked there.
  ImageF glass_or_mirror(const View& view, const Intrinsics& k) const;
  ImageF mirror_only(const View& view, const Intrinsics& k) const;
};

}  // namespace vitrine
