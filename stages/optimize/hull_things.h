// Things in a hull that have a solid of revolution, with their appendages: each gets a surface of its own,
// finer than the cells of the whole hull, and what stands out of its solids.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/voxel_grid.h"
#include "core/stereo/revolution_fit.h"
#include "stages/optimize/hull.h"
#include "stages/optimize/hull_judges.h"

namespace vitrine {

// The cells of `inside` that hang together, by number of the thing from 1 on; 0: empty. Those around the solids come first, one
// thing for each solid that begins one; returns how many.
struct HullThings {
  VoxelGrid<uint32_t> of;
  uint32_t with_solids = 0;
};
HullThings hull_things(const VoxelGrid<uint8_t>& inside, std::span<const HullSurfacePoint> surface,
                       std::span<const SolidOfRevolution> solids);

// Adds the points and what stands out of the solids of every thing with solids. `carried`: the masks are not drawn to a pixel
// (Targets::carried).
void add_things(const HullThings& things, const std::vector<HullJudge>& judges, bool carried, Hull& hull);

}  // namespace vitrine
