// The light that was found, as a lat-long map (core/light/environment.h).
#pragma once

#include "core/image/image.h"
#include "stages/decompose/light_solver.h"

namespace vitrine {

// Seen walls and sky as they are, divided by `unit`; the rest as solved, and in its mean where no point told it. [height, 2
// height]
ImageF environment_map(const Surroundings& around, const LightGrid& grid, const LightSolution& solution, const Vec3f& unit);

}  // namespace vitrine
