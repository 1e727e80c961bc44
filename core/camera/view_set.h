// Reads and writes what the sfm stage hands to everyone: sparse/0 (COLMAP), transforms.json, scene.json, gains.json.
#pragma once

#include <filesystem>

#include "core/camera/colmap_model.h"
#include "core/camera/view.h"

namespace vitrine {

// From an sfm artifact folder (sparse/0/*.bin + sfm/gains.json + scene.json). Throws Error{Input} with file and cause.
ViewSet load_view_set(const std::filesystem::path& sfm_folder);
// Path of a view's undistorted linear EXR inside an sfm artifact: linear/<stem>.exr.
std::filesystem::path linear_image_path(const std::filesystem::path& sfm_folder, const View& view);

// nerfstudio / instant-ngp / Blender transforms.json: camera-to-world, OpenGL axes. Understood: intrinsics at the top or per
// frame, camera_angle_x / _y, extension-less file_path, applied_transform and applied_scale (undone). Names are relative to the
// folder "images" or to the deepest folder that all frames share. When w and h are missing the first photo is opened.
std::vector<View> read_transforms_json(const std::filesystem::path& path);  // sorted by name; refuses lens distortion
ColmapModel read_transforms_model(const std::filesystem::path& path);       // keeps it (OPENCV cameras); no points
void write_transforms_json(const std::filesystem::path& path, const std::vector<View>& views, const std::string& image_folder);

}  // namespace vitrine
