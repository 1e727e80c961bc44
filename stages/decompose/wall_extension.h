// Wall extension: walls end where the photos end, not where the room does. Sky and lamps are brighter than the walls that they
// light. Where the solved light right above a wall is no brighter than the wall, more wall stands there: the shell of the
// surroundings is extended straight up to the first band of light cells that is brighter. Under the light of the photos it
// changes little (those cells are dark); under another light it keeps a low sun out. Light from low over the walls, which few
// points see, is estimated too dark: where a specular object shows from which elevation on sky is mirrored (mirrored_horizon),
// walls end there at the latest.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"
#include "stages/decompose/light_grid.h"
#include "stages/decompose/lit_points.h"
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

inline constexpr float kMaxAlbedo = 0.98f;  // of what gives back no more light than it gets

// The shell of what stands around, for other lights: the albedo of the surfels there in place of the radiance they had.
// `irradiance` [surfels of `layer`] under the light of the photos; surfels within `reach` of a corner tell its own.
TriMesh painted_shell(const ExtendedWalls& walls, const SplatLayer& layer, std::span<const Vec3f> irradiance, float reach);

// How high walls stand that no photo shows: polished things show it. What they mirror is trained into the reflection layer, and
// seen from their middle it is dark where walls are and bright where the sky is.
// Sine of the elevation at which the light half-way between walls and sky is crossed (medians over the azimuths): the edge that a
// rough or coarse mirror shows softened. Nothing, where too few of the points are polished, where their mirrors never looked, or
// where what is high up is not at least twice as bright.
std::optional<float> mirrored_horizon(const SplatLayer& reflection, std::span<const LitPoint> points);

}  // namespace vitrine
