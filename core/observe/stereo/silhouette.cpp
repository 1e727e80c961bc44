#include "core/observe/stereo/silhouette.h"

#include <algorithm>
#include <cmath>

#include "core/scene/camera/view_masks.h"
#include "core/scene/image/resample.h"

namespace vitrine {

Silhouette silhouette(const View& view, const std::vector<uint8_t>& inside) {
  Silhouette out{view, ImageF(view.intrinsics.width, view.intrinsics.height, 1)};
  std::copy(inside.begin(), inside.end(), out.value.data().begin());
  return out;
}

float coverage_at(const ImageF& value, double x, double y) {
  x -= 0.5, y -= 0.5;
  const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= value.width() || y0 + 1 >= value.height()) return -1;
  const float u = float(x - x0), v = float(y - y0);
  const float a = value.at(x0, y0), b = value.at(x0 + 1, y0), c = value.at(x0, y0 + 1), d = value.at(x0 + 1, y0 + 1);
  if (a < 0 || b < 0 || c < 0 || d < 0) return -1;
  return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d);
}

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
