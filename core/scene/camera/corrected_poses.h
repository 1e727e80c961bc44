// Poses that training corrected (option `poses` of the optimize stage): optimize/poses.json of an optimize artifact, in the scene
// frame. Without the file the poses of the sfm artifact hold. What compares photos with the trained scene uses these poses.
#pragma once

#include <filesystem>
#include <vector>

#include "core/scene/camera/view_set.h"

namespace vitrine {

void write_corrected_poses(const std::filesystem::path& optimize_folder, const std::vector<View>& views);
bool has_corrected_poses(const std::filesystem::path& optimize_folder);
// Replaces the poses of the views that the file names; without a file they stay. Throws Error{Input} if the file is damaged.
void correct_poses(const std::filesystem::path& optimize_folder, std::vector<View>& views);
// load_view_set() of an sfm artifact, with the poses of an optimize artifact.
ViewSet load_view_set(const std::filesystem::path& sfm_folder, const std::filesystem::path& optimize_folder);

}  // namespace vitrine
