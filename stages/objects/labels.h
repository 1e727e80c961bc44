// Label images (core/scene/objects/object_labels.h): which object each pixel shows that the masks mark.
#pragma once

#include <filesystem>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/image/image.h"
#include "core/scene/objects/object_set.h"

namespace vitrine {

// Marked pixels that show no shape, nor lie at the rim of one, belong to these objects: glass and gloss whose place the photos
// do not fix.
struct UnlocatedObjects {
  uint16_t glass = 0, specular = 0;
};

// Labels of one photo at the size of its masks. `masks`: the artifact of the masks stage. A pixel of a class belongs to the
// nearest object of that class that its ray meets; where it meets none, to the one that pixels within three of 240 show. The
// transparent mask is in front of the specular one. Empty: the photo has no mask of either class.
Image16 labelled_pixels(const std::filesystem::path& masks, const View& photo, const ObjectSet& set,
                        const UnlocatedObjects& unlocated);

}  // namespace vitrine
