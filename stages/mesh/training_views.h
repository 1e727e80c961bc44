// Which views the optimize stage trained on, and at which size: optimize/views.json.
#pragma once

#include <filesystem>
#include <vector>

#include "core/camera/view.h"

namespace vitrine {

// The training views, intrinsics scaled to the training size or to `max_side` when that is given (> 0). Throws Error{Input}
// when the file is damaged or names a view that the sfm artifact does not have.
std::vector<View> training_views(const ViewSet& set, const std::filesystem::path& optimize_folder, int max_side);

}  // namespace vitrine
