// Wall extension: continues the walls above the photographed part. Sky and lamps are brighter than the walls they light. Where
// the solved light directly above a wall is no brighter than the wall, the shell of the surroundings is extended vertically up to
// the first brighter band of light cells. Under the captured light this changes little (those cells are dark); under another
// light it blocks a low sun. Light from low above the walls reaches few points and is underestimated, so walls end at the latest
// at the elevation above which a specular object reflects sky (mirrored_horizon).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"
#include "stages/decompose/lit_points.h"
#include "stages/decompose/surroundings.h"
#include "stages/decompose/transport.h"

namespace vitrine {

struct ExtendedWalls {
  Surroundings around;         // with the extension
  std::vector<size_t> source;  // [texels] the texel that each extended texel copies; its own index elsewhere
  float sine = 0;              // sine of the highest elevation of the extension; 0: none
};

// `light`, `free`: of the cells of `grid`, as solved. `horizon`: sine of the elevation above which sky is reflected.
ExtendedWalls extended_walls(const Surroundings& around, const LightGrid& grid, std::span<const Vec3f> light,
                             const std::vector<bool>& free, float horizon = 1);

inline constexpr float kMaxAlbedo = 0.98f;  // upper bound of energy conservation

// The shell of the surroundings for relighting: albedo of its surfels instead of their radiance. `irradiance` [surfels of
// `layer`] under the captured light; surfels within `reach` of a vertex determine its albedo.
TriMesh painted_shell(const ExtendedWalls& walls, const SplatLayer& layer, std::span<const Vec3f> irradiance, float reach);

// Elevation of unphotographed wall tops, from specular objects: their reflections are trained into the reflection layer, which is
// dark towards walls and bright towards the sky, as seen from the centre of the specular points. Returns the sine of the
// elevation where the light is half-way between walls and sky (medians over the azimuths), which is also the edge of a blurred
// reflection. Empty with too few specular points, without reflections in these directions, or if the upper light is less than
// twice as bright.
std::optional<float> mirrored_horizon(const SplatLayer& reflection, std::span<const LitPoint> points);

}  // namespace vitrine
