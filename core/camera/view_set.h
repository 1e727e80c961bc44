// Reads and writes what the sfm stage hands to everyone: sparse/0 (COLMAP), transforms.json, scene.json, gains.json.
#pragma once

#include <filesystem>

#include "core/camera/view.h"

namespace vitrine {

// From an sfm artifact folder (sparse/0/*.bin + gains.json + scene.json). Throws Error{Input} with file and cause.
ViewSet load_view_set(const std::filesystem::path& sfm_folder);
// Path of a view's undistorted linear EXR inside an sfm artifact: linear/<stem>.exr.
std::filesystem::path linear_image_path(const std::filesystem::path& sfm_folder, const View& view);

// nerfstudio / instant-ngp transforms.json: camera-to-world, OpenGL axes. Extension-less file_path is allowed.
std::vector<View> read_transforms_json(const std::filesystem::path& path);
void write_transforms_json(const std::filesystem::path& path, const std::vector<View>& views, const std::string& image_folder);

}  // namespace vitrine
