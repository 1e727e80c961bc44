// Distances to nearest neighbours in a point cloud.
#pragma once

#include <span>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

// Root of the mean squared distance of every point to its three nearest others; 0 where there are no others.
std::vector<float> neighbour_spacing(std::span<const Vec3f> points);

}  // namespace vitrine
