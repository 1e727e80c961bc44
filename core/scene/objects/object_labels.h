// Object labels of photos: objects/labels/<stem>.png, 16 bit, size of the undistorted photo. A pixel contains the id of the
// nearest object that is not plain opaque, or 0.
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

// Object table and labels of an artifact of the stage `objects`.
class LabelledObjects {
 public:
  LabelledObjects() = default;  // none
  // `which`: the object table to use; labels of other objects read as 0. Throws Error{Input}.
  LabelledObjects(std::optional<std::filesystem::path> artifact, ObjectSet which);
  static LabelledObjects trusted(const std::optional<std::filesystem::path>& artifact) {
    return {artifact, read_objects(artifact).trusted()};
  }
  static LabelledObjects known(const std::optional<std::filesystem::path>& artifact) {
    return {artifact, read_objects(artifact).known()};
  }
  static LabelledObjects all(const std::optional<std::filesystem::path>& artifact) { return {artifact, read_objects(artifact)}; }

  const ObjectSet& objects() const { return objects_; }
  // Labels of the photo with the view's name, resampled to the view's size (nearest neighbour); empty: no labels.
  Image16 labels(const View& photo, const Intrinsics& size) const;
  // Fraction of each pixel, [h,w,1] in [0,1], that shows an object accepted by `counts`; empty: the photo has no labels.
  ImageF coverage(const View& photo, const Intrinsics& size, const std::function<bool(const Object&)>& counts) const;
  bool any(const std::function<bool(const Object&)>& counts) const;

 private:
  Image16 read(const View& photo) const;
  std::optional<std::filesystem::path> artifact_;
  ObjectSet objects_;
};

// Masks of a class per photo: glass (transparent) and specular (including glass) from the object labels; object and ignore from
// their mask files.
class ClassPixels {
 public:
  ClassPixels() = default;  // none
  // `masks`: artifact of the masks stage.
  ClassPixels(std::optional<std::filesystem::path> masks, LabelledObjects objects);

  bool has(MaskClass kind) const;
  // [h,w,1] in [0,1] at the size of the view; nullopt: no data for this photo. Throws Error{Input}.
  std::optional<ImageF> of(MaskClass kind, const View& photo) const;
  const ObjectSet& objects() const { return objects_.objects(); }

 private:
  std::optional<std::filesystem::path> masks_;
  LabelledObjects objects_;
};

}  // namespace vitrine
