// Camera paths for rendering, in file order.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "core/scene/camera/transforms_file.h"
#include "core/scene/camera/view.h"

namespace vitrine {

struct CameraPathDesc {
  std::filesystem::path file;               // transforms.json, or camera_path.json of the nerfstudio viewer
  std::optional<PictureSize> size;          // image size if the file has none
  std::function<PictureSize()> usual_size;  // same, for cameras defined by their field of view
};
// Views are named frame_0000.png and so on: names in the file may be invalid here or sort differently. Opens no image. Throws
// Error{Input}.
std::vector<View> read_camera_path(const CameraPathDesc& desc);

}  // namespace vitrine
