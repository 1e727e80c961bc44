// The shell of what stands around, for other lights: the albedo of the surfels there in place of the radiance they had.
#pragma once

#include <span>

#include "core/mesh/tri_mesh.h"
#include "core/scene/layers.h"
#include "stages/decompose/wall_extension.h"

namespace vitrine {

inline constexpr float kMaxAlbedo = 0.98f;  // of what gives back no more light than it gets

// `irradiance` [surfels of `layer`] under the light of the photos; surfels within `reach` of a corner tell its own.
TriMesh painted_shell(const ExtendedWalls& walls, const SplatLayer& layer, std::span<const Vec3f> irradiance, float reach);

}  // namespace vitrine
