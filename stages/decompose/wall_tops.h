// Walls end where the photos end, not where the room does. What the solved light says about the directions above them: no
// brighter than the walls themselves means that more wall stands there, for sky and lamps are brighter than what they light. Up
// to the first band of light cells that is brighter, walls are continued straight up. Under the light of the photos it changes
// little (those cells are dark); under another light it keeps a low sun out. Light from low over the walls, which few points
// see, is found too dark: where something polished shows how high they are (mirrored_sky.h), they end there at the latest.
#pragma once

#include <span>
#include <vector>

#include "stages/decompose/light_grid.h"
#include "stages/decompose/surroundings.h"

namespace vitrine {

struct WallTops {
  Surroundings around;         // with what was added
  std::vector<size_t> source;  // [texels] whose surface it continues; itself, where nothing was added
  float sine = 0;              // of the elevation up to which walls were continued; 0: nowhere
};

// `light`, `free`: of the cells of `grid`, as solved. `horizon`: sine of the elevation above which sky is mirrored.
WallTops continued_walls(const Surroundings& around, const LightGrid& grid, std::span<const Vec3f> light,
                         const std::vector<bool>& free, float horizon = 1);

}  // namespace vitrine
