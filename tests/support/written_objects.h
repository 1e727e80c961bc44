// An artifact of the stage `objects`, as that stage would leave it for masks of one object a class.
#pragma once

#include <algorithm>

#include "core/foundation/base/file.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/image/ldr.h"
#include "core/scene/objects/object_labels.h"

namespace vitrine::test {

// `masks`: an artifact of the masks stage. What it marks as glass has the label of the first object of glass of `set`, what else
// is marked as specular that of the first other object; where the set has none of a class, it gets one without a shape.
inline fs::path write_objects_artifact(const fs::path& artifact, const fs::path& masks, const std::vector<View>& views,
                                       ObjectSet set = {}) {
  const auto first = [&](bool glass, ObjectRole otherwise) {
    for (const Object& o : set.objects)
      if (is_glass(o.role) == glass) return o.id;
    const auto id = static_cast<uint16_t>(set.objects.empty() ? 1 : set.objects.back().id + 1);
    set.objects.push_back({.id = id, .name = glass ? "glass" : "reflecting", .role = otherwise});
    return id;
  };
  make_folders(artifact / "objects");
  for (const bool glass : {false, true}) {
    const MaskClass kind = glass ? MaskClass::Transparent : MaskClass::Specular;
    if (!fs::is_directory(masks / "masks" / name(kind))) continue;
    const uint16_t id = first(glass, glass ? ObjectRole::ThinGlass : ObjectRole::Coat);
    for (const View& view : views) {
      const auto mask = read_view_mask(masks, kind, view);
      if (!mask) continue;
      const fs::path path = label_path(artifact, view);
      Image16 labels(mask->width(), mask->height(), 1);
      if (fs::exists(path)) {
        const ImageF before = read_unchanged(path);
        std::ranges::transform(before.data(), labels.data().begin(),
                               [](float v) { return static_cast<uint16_t>(std::lround(65535.f * v)); });
      }
      for (size_t i = 0; i < labels.data().size(); ++i)
        if (mask->data()[i] >= 0.5f) labels.data()[i] = id;
      make_folders(path.parent_path());
      write_png16(path, labels);
    }
  }
  write_objects(artifact / "objects", set);
  return artifact;
}

// One object with one shape.
inline ObjectSet one_object(const Shape& shape, ObjectRole role, double tolerance, bool exact = true) {
  return {.objects = {{.id = 1, .name = "object", .role = role}},
          .shapes = {
              .entries = {
                  {.shape = shape, .role = shape_role(role), .tolerance = tolerance, .clear = {}, .exact = exact, .object = 1}}}};
}

}  // namespace vitrine::test
