// Poses of a COLMAP model or a transforms.json for the photos that their names mean. What is read, what is left out and what is
// assumed is said.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "core/foundation/base/note.h"
#include "core/scene/camera/colmap_model.h"
#include "core/intake/photos/photo_list.h"
#include "core/intake/poses/pose_files.h"

namespace vitrine {

struct NamedPoses {
  PoseFile file;                 // what was read
  ColmapModel model;             // image names are names of photos, each at most once; cameras as the file has them
  std::vector<size_t> versions;  // photos without a pose that are another version of a photo with one: "images_4/a.jpg"
  Notes notes;
};

// Of several files the one that has poses of most photos; of equally good ones the first. Throws Error{Input}: nothing can be
// read, nothing matches, two different poses of one photo, no focal length.
NamedPoses named_poses(std::span<const PoseFile> files, std::span<const Photo> photos);

}  // namespace vitrine
