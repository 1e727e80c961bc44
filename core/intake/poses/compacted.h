// Removes points or images from a COLMAP model and renumbers the rest.
#pragma once

#include <cstdint>
#include <functional>
#include <set>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

// Keeps the points for which `keep` holds. Removes 2D points without a 3D point, renumbers ids to 1..n and updates the tracks.
// Observations whose 2D point has lost its 3D point are removed from the tracks first.
ColmapModel compacted(ColmapModel model, const std::function<bool(const ColmapPoint3D&)>& keep);

// Removes these images (ids), points seen by fewer than two of the rest, and unused cameras.
ColmapModel without_images(ColmapModel model, const std::set<uint32_t>& images);

}  // namespace vitrine
