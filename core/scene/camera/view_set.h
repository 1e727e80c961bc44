// View set of the sfm stage: reads and writes sparse/0 (COLMAP), transforms.json, scene.json, gains.json.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/transforms_file.h"
#include "core/scene/camera/view.h"

namespace vitrine {

// From an sfm artifact folder (sparse/0/*.bin + sfm/gains.json + scene.json). Throws Error{Input} with file and cause.
ViewSet load_view_set(const std::filesystem::path& sfm_folder);
// Path of the undistorted linear EXR of a view in an sfm artifact: linear/<stem>.exr.
std::filesystem::path linear_image_path(const std::filesystem::path& sfm_folder, const View& view);

// Reads a transforms.json (core/scene/camera/transforms_file.h) as undistorted views, sorted by name. Names are relative to the
// folder "images" or to the deepest common folder of all frames. Throws for lens distortion, and for frames without w and h for
// which `size_of` returns no size.
using SizeOfView = std::function<std::optional<PictureSize>(const std::string& name)>;
std::vector<View> read_transforms_json(const std::filesystem::path& path, const SizeOfView& size_of = {});
void write_transforms_json(const std::filesystem::path& path, const std::vector<View>& views, const std::string& image_folder);

}  // namespace vitrine
