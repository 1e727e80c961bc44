// Nearest-neighbour distances in a point cloud.
#pragma once

#include <span>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

// Root mean square distance from each point to its three nearest neighbours; 0 for a single point.
std::vector<float> neighbour_spacing(std::span<const Vec3f> points);

}  // namespace vitrine
