// Poses of a COLMAP model, a transforms.json or a file of another program, matched to photos by name. Notes report the file read,
// omissions and assumptions.
#pragma once

#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/intake/photos/photo_list.h"
#include "core/intake/poses/pose_files.h"
#include "core/scene/camera/colmap_model.h"

namespace vitrine {

// Code of the note on masks that the file of poses names and that are not read with the poses (mask_path).
inline constexpr std::string_view kMasksNamed = "POSES_NAME_MASKS";

struct NamedPoses {
  PoseFile file;                 // the file read
  ColmapModel model;             // image names are names of photos, each at most once; cameras as in the file
  std::vector<size_t> versions;  // photos without a pose that are another version of a posed photo: "images_4/a.jpg"
  Notes notes;
};

// Of several files, the one with poses for the most photos, the first on a tie. Throws Error{Input}: no file is readable, no
// name matches, two different poses of one photo, no focal length.
NamedPoses named_poses(std::span<const PoseFile> files, std::span<const Photo> photos);

}  // namespace vitrine
