#include "core/scene/objects/object_labels.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace fs = std::filesystem;

fs::path label_path(const fs::path& artifact, const View& view) {
  return artifact / "objects" / "labels" / (view.stem() + ".png");
}

LabelledObjects::LabelledObjects(std::optional<fs::path> artifact, ObjectSet which)
    : artifact_(std::move(artifact)), objects_(std::move(which)) {}

Image16 LabelledObjects::read(const View& photo) const {
  std::error_code ec;
  if (!artifact_ || objects_.empty() || !fs::exists(label_path(*artifact_, photo), ec)) return {};
  const ImageF file = read_unchanged(label_path(*artifact_, photo));
  if (file.channels() != 1)
    throw Error(ErrorKind::Input, "a label image has colours",
                {.where = label_path(*artifact_, photo).string(), .hint = "run the objects stage again", .code = "BAD_LABELS"});
  Image16 out(file.width(), file.height(), 1);
  std::vector<uint8_t> known(65536, 0);
  for (const Object& o : objects_.objects) known[o.id] = 1;
  for (size_t i = 0; i < out.data().size(); ++i) {
    const auto id = static_cast<uint16_t>(std::lround(65535.f * file.data()[i]));
    out.data()[i] = known[id] ? id : uint16_t(0);
  }
  return out;
}

Image16 LabelledObjects::labels(const View& photo, const Intrinsics& size) const {
  const Image16 full = read(photo);
  if (full.empty() || (full.width() == size.width && full.height() == size.height)) return full;
  Image16 out(size.width, size.height, 1);
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x)
      out.at(x, y) = full.at((2 * x + 1) * full.width() / (2 * size.width), (2 * y + 1) * full.height() / (2 * size.height));
  return out;
}

ImageF LabelledObjects::coverage(const View& photo, const Intrinsics& size,
                                 const std::function<bool(const Object&)>& counts) const {
  const Image16 full = read(photo);
  if (full.empty()) return {};
  std::vector<uint8_t> counted(65536, 0);
  for (const Object& o : objects_.objects) counted[o.id] = counts(o);
  ImageF out(full.width(), full.height(), 1);
  std::ranges::transform(full.data(), out.data().begin(), [&](uint16_t id) { return counted[id] ? 1.f : 0.f; });
  return full.width() == size.width && full.height() == size.height ? out : resized(out, size.width, size.height);
}

bool LabelledObjects::any(const std::function<bool(const Object&)>& counts) const {
  return std::ranges::any_of(objects_.objects, counts);
}

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
