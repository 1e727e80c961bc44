// A COLMAP model with some of its points or images taken out.
#pragma once

#include <cstdint>
#include <functional>
#include <set>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

// Keeps the points for which `keep` holds; 2D points without a 3D point leave; ids become 1..n; tracks follow. Observations whose
// 2D point lost its 3D point are first taken out of the tracks.
ColmapModel compacted(ColmapModel model, const std::function<bool(const ColmapPoint3D&)>& keep);

// Without these images (ids), the points that fewer than two others see, and the cameras of none.
ColmapModel without_images(ColmapModel model, const std::set<uint32_t>& images);

}  // namespace vitrine
