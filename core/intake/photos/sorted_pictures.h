// Which pictures of a folder are photos, and which are something that belongs to one: sorted by name and content, both of which
// have to agree before a picture is left out.
#pragma once

#include <string>
#include <vector>

#include "core/intake/photos/photo_files.h"

namespace vitrine {

// Moves out of `folder.photos` into `folder.beside` the masks, depth maps, maps of normals and reduced copies of other photos,
// and into `folder.like_photos` the names of those that are called so and look like photos. Decodes pictures only where names ask
// for it.
void sort_pictures(PhotoFolder& folder);

}  // namespace vitrine
