// Which pixels of a photo show a class of what people mark: glass (transparent) and what reflects (specular, glass among it) by
// the labels of objects, the object and what is to be ignored by their masks.
#pragma once

#include <optional>

#include "core/camera/mask_files.h"
#include "core/objects/object_labels.h"

namespace vitrine {

class ClassPixels {
 public:
  ClassPixels() = default;  // none
  // `masks`: an artifact of the masks stage.
  ClassPixels(std::optional<std::filesystem::path> masks, LabelledObjects objects);

  bool has(MaskClass kind) const;
  // [h,w,1] in [0,1] at the size of the photo's view; nullopt: nothing is known of this photo. Throws Error{Input}.
  std::optional<ImageF> of(MaskClass kind, const View& photo) const;
  const ObjectSet& objects() const { return objects_.objects(); }

 private:
  std::optional<std::filesystem::path> masks_;
  LabelledObjects objects_;
};

}  // namespace vitrine
