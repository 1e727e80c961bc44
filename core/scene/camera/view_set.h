// Reads and writes what the sfm stage hands to everyone: sparse/0 (COLMAP), transforms.json, scene.json, gains.json.
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
// Path of a view's undistorted linear EXR inside an sfm artifact: linear/<stem>.exr.
std::filesystem::path linear_image_path(const std::filesystem::path& sfm_folder, const View& view);

// A transforms.json (core/scene/camera/transforms_file.h) as cameras of undistorted views, sorted by name. Names are relative to the
// folder "images" or to the deepest folder that all frames share. Refuses lens distortion, and frames without w and h for which
// `size_of` knows no size.
using SizeOfView = std::function<std::optional<PictureSize>(const std::string& name)>;
std::vector<View> read_transforms_json(const std::filesystem::path& path, const SizeOfView& size_of = {});
void write_transforms_json(const std::filesystem::path& path, const std::vector<View>& views, const std::string& image_folder);

}  // namespace vitrine
