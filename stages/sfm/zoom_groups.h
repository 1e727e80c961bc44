// Photos of one camera with different focal lengths by EXIF, where the focal length in pixels is unknown or does not show it.
#pragma once

#include <span>
#include <vector>

#include "core/intake/photos/photo_list.h"
#include "stages/sfm/reconstruct.h"

namespace vitrine {

// Gives photos of equal camera, size and prior, but different zoom, a camera each by their `camera`. A prior that is equal for
// all, of FocalLengthIn35mmFilm without the digital zoom, belongs to the widest; the others are in proportion. list[i] is of
// photos[i].
void part_by_zoom(std::vector<SfmPhoto>& list, std::span<const Photo> photos);

}  // namespace vitrine
