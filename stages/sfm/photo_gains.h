// Exposure and white balance of each photo, from the colours of the tracks in the undistorted photos (gains/gains.h).
#pragma once

#include <filesystem>
#include <vector>

#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"

namespace vitrine {

class StageContext;

// `model`: of the undistorted pictures in `output`; `photos`: theirs. Views cut from one photo have one exposure: their tracks
// count together. Reports metrics, and photos whose tracks have too few colours.
Gains photo_gains(const ColmapModel& model, const std::vector<Photo>& photos, const std::filesystem::path& output,
                  StageContext& context);

}  // namespace vitrine
