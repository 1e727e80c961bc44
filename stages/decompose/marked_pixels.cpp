#include "stages/decompose/marked_pixels.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/camera/view_masks.h"
#include "core/image/resample.h"

namespace vitrine {

namespace {

ImageF mask(const MarkedPixels& marks, MaskClass kind, const View& view, const Intrinsics& k) {
  const auto photo = std::ranges::find(marks.photos, view.name, &View::name);
  VITRINE_CHECK(photo != marks.photos.end(), "no photo is called {}", view.name);
  const auto file = marks.masks ? read_view_mask(*marks.masks, kind, *photo) : std::nullopt;
  return file ? resized(*file, k.width, k.height) : ImageF();
}

}  // namespace

ImageF MarkedPixels::glass_or_mirror(const View& view, const Intrinsics& k) const {
  ImageF out = mask(*this, MaskClass::Transparent, view, k);
  const ImageF specular = mask(*this, MaskClass::Specular, view, k);
  if (out.empty()) return specular;
  for (size_t i = 0; i < specular.data().size(); ++i) out.data()[i] = std::max(out.data()[i], specular.data()[i]);
  return out;
}

ImageF MarkedPixels::mirror_only(const View& view, const Intrinsics& k) const {
  ImageF out = mask(*this, MaskClass::Specular, view, k);
  const ImageF glass = mask(*this, MaskClass::Transparent, view, k);
  if (out.empty() || glass.empty()) return out;
  for (size_t i = 0; i < out.data().size(); ++i) out.data()[i] = std::min(out.data()[i], 1 - glass.data()[i]);
  return out;
}

}  // namespace vitrine
