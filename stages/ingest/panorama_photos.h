// The views of a panorama as photos (core/scene/camera/panorama_views.h).
#pragma once

#include <span>

#include "core/intake/photos/photo_files.h"
#include "core/intake/photos/photo_list.h"
#include "core/scene/image/image.h"

namespace vitrine::ingest {

// Writes the linear and the 8-bit picture of each view, of at most `max_side` pixels a side (0 = no limit). `panorama`: its
// fields hold for all views; name, stem, size and focal length are those of each view.
std::vector<Photo> write_panorama_views(ImageF linear, const Photo& panorama, const std::string& folder, int max_side,
                                        const std::filesystem::path& output);
// Folder of the views of each photo if it is a panorama: its stem, with '_' appended until no photo lies in it.
std::vector<std::string> view_folders(std::span<const PhotoFile> photos);

}  // namespace vitrine::ingest
