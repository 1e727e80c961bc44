// Which object a pixel of a photo shows: objects/labels/<stem>.png, 16 bit, as large as the undistorted photo, the id of the
// nearest object that is not plain opaque; 0: none.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/objects/object_set.h"

namespace vitrine {

std::filesystem::path label_path(const std::filesystem::path& artifact, const View& view);

// The table and the labels of an artifact of the stage `objects`.
class LabelledObjects {
 public:
  LabelledObjects() = default;  // none
  // `which`: the table to go by; labels of other objects read as 0. Throws Error{Input}.
  LabelledObjects(std::optional<std::filesystem::path> artifact, ObjectSet which);
  static LabelledObjects trusted(const std::optional<std::filesystem::path>& artifact) {
    return {artifact, read_objects(artifact).trusted()};
  }
  static LabelledObjects known(const std::optional<std::filesystem::path>& artifact) {
    return {artifact, read_objects(artifact).known()};
  }
  static LabelledObjects all(const std::optional<std::filesystem::path>& artifact) { return {artifact, read_objects(artifact)}; }

  const ObjectSet& objects() const { return objects_; }
  // Labels of the photo of a view (its name counts) at the view's size, nearest; empty: the photo has none.
  Image16 labels(const View& photo, const Intrinsics& size) const;
  // Share of each pixel, [h,w,1] in [0,1], that shows an object which `counts`; empty: the photo has no labels.
  ImageF coverage(const View& photo, const Intrinsics& size, const std::function<bool(const Object&)>& counts) const;
  bool any(const std::function<bool(const Object&)>& counts) const;

 private:
  Image16 read(const View& photo) const;
  std::optional<std::filesystem::path> artifact_;
  ObjectSet objects_;
};

// Which pixels of a photo show a class of what people mark: glass (transparent) and what reflects (specular, glass among it) by
// the labels of objects, the object and what is to be ignored by their masks.
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
