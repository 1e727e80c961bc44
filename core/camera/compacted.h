// A COLMAP model with some of its points taken out.
#pragma once

#include <functional>

#include "core/camera/colmap_model.h"

namespace vitrine {

// Keeps the points for which `keep` holds; 2D points without a 3D point leave; ids become 1..n; tracks follow. Observations whose
// 2D point lost its 3D point are first taken out of the tracks.
ColmapModel compacted(ColmapModel model, const std::function<bool(const ColmapPoint3D&)>& keep);

}  // namespace vitrine
