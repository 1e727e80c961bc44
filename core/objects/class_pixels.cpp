#include "core/objects/class_pixels.h"

#include "core/camera/view_masks.h"

namespace vitrine {

namespace {

bool is_of(MaskClass kind, const Object& object) {
  return kind == MaskClass::Transparent ? is_glass(object.role) : is_specular(object.role);
}
bool is_labelled(MaskClass kind) { return kind == MaskClass::Transparent || kind == MaskClass::Specular; }

}  // namespace

ClassPixels::ClassPixels(std::optional<std::filesystem::path> masks, LabelledObjects objects)
    : masks_(std::move(masks)), objects_(std::move(objects)) {}

bool ClassPixels::has(MaskClass kind) const {
  if (is_labelled(kind)) return objects_.any([&](const Object& o) { return is_of(kind, o); });
  std::error_code ec;
  return masks_ && std::filesystem::is_directory(*masks_ / "masks" / name(kind), ec);
}

std::optional<ImageF> ClassPixels::of(MaskClass kind, const View& photo) const {
  if (!has(kind)) return std::nullopt;
  if (!is_labelled(kind)) return read_view_mask(*masks_, kind, photo);
  ImageF out = objects_.coverage(photo, photo.intrinsics, [&](const Object& o) { return is_of(kind, o); });
  return out.empty() ? std::nullopt : std::optional(std::move(out));
}

}  // namespace vitrine
