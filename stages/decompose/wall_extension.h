// Wall extension: walls end where the photos end, not where the room does. Sky and lamps are brighter than the walls that they
// light. Where the solved light right above a wall is no brighter than the wall, more wall stands there: the shell of the
// surroundings is extended straight up to the first band of light cells that is brighter. Under the light of the photos it
// changes little (those cells are dark); under another light it keeps a low sun out. Light from low over the walls, which few
// points see, is estimated too dark: where a specular object shows from which elevation on sky is mirrored (mirrored_sky.h),
// walls end there at the latest.
#pragma once

#include <span>
#include <vector>

#include "stages/decompose/light_grid.h"
#include "stages/decompose/surroundings.h"

namespace vitrine {

struct ExtendedWalls {
  Surroundings around;         // with what was added
  std::vector<size_t> source;  // [texels] whose surface it continues; itself, where nothing was added
  float sine = 0;              // of the elevation up to which walls were continued; 0: nowhere
};

// `light`, `free`: of the cells of `grid`, as solved. `horizon`: sine of the elevation above which sky is mirrored.
ExtendedWalls extended_walls(const Surroundings& around, const LightGrid& grid, std::span<const Vec3f> light,
                             const std::vector<bool>& free, float horizon = 1);

}  // namespace vitrine
