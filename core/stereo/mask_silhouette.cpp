#include "core/stereo/mask_silhouette.h"

#include <algorithm>

#include "core/camera/view_masks.h"
#include "core/image/resample.h"

namespace vitrine {

namespace {

constexpr float kHalf = 0.5f;

}  // namespace

std::optional<Silhouette> mask_silhouette(const std::filesystem::path& masks, MaskClass kind, const View& photo,
                                          const Intrinsics& size) {
  const auto mask = read_view_mask(masks, kind, photo);
  if (!mask) return std::nullopt;
  Silhouette out{photo, {}};
  out.view.intrinsics = size;
  out.value = resized(*mask, size.width, size.height);
  if (kind == MaskClass::Transparent) return out;
  if (const auto glass = read_view_mask(masks, MaskClass::Transparent, photo)) {
    const ImageF in_front = resized(*glass, size.width, size.height);
    for (size_t i = 0; i < out.value.data().size(); ++i)
      if (in_front.data()[i] >= kHalf) out.value.data()[i] = -1;
  }
  return out;
}

bool marks_something(const Silhouette& silhouette) {
  return std::ranges::any_of(silhouette.value.data(), [](float value) { return value >= kHalf; });
}

}  // namespace vitrine
