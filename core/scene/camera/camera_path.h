// Cameras to picture a scene from, in the order of their file: a film is rendered as it was written.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "core/scene/camera/transforms_file.h"
#include "core/scene/camera/view.h"

namespace vitrine {

struct CameraPathDesc {
  std::filesystem::path file;               // a transforms.json, or a camera_path.json of nerfstudio's viewer
  std::optional<PictureSize> size;          // of the pictures, where the file states none
  std::function<PictureSize()> usual_size;  // likewise, of cameras that are given by their angle of view
};
// Views are named frame_0000.png on: names in such a file need not fit this file system, and sort in another order. No picture is
// opened. Throws Error{Input}.
std::vector<View> read_camera_path(const CameraPathDesc& desc);

}  // namespace vitrine
