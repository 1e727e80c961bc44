// Label images (core/scene/objects/object_labels.h): the object of each marked pixel.
#pragma once

#include <filesystem>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/objects/object_set.h"

namespace vitrine {

// Objects for marked pixels that show no shape and are not next to one: glass and specular surfaces whose position the photos do
// not determine.
struct UnlocatedObjects {
  uint16_t glass = 0, specular = 0;
};

// Labels of one photo at mask size. `masks`: artifact of the masks stage. A pixel of a class belongs to the nearest object of
// that class on its ray; without a hit, to the object within three of 240 pixels. The transparent mask is in front of the
// specular one. Empty: the photo has no mask of either class.
Image16 labelled_pixels(const std::filesystem::path& masks, const View& photo, const ObjectSet& set,
                        const UnlocatedObjects& unlocated);

}  // namespace vitrine
