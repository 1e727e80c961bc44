// Separates the photos of a folder from masks, depth maps and other companions. A picture is left out only if its name and its
// content agree.
#pragma once

#include <string>
#include <vector>

#include "core/intake/photos/photo_files.h"

namespace vitrine {

// Moves masks, depth maps, normal maps and reduced copies from `folder.photos` to `folder.beside`, and records in
// `folder.like_photos` the files that have such a name but look like photos. Decodes only pictures with such a name.
void sort_pictures(PhotoFolder& folder);

}  // namespace vitrine
