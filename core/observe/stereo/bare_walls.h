// Plane sweep for textureless walls and floors, which scene_planes.h misses because stereo finds no depth in their middle.
// Borders and shading constrain them: warped through the correct plane, pixels without reliable depth match the other photos
// better than at any other depth or at infinity. The search covers planes that bound all cameras and all stereo points: vertical
// walls, and a floor where stereo found none. A plane is accepted only if moving or turning it makes the match worse, which
// rejects the sky.
#pragma once

#include "core/observe/stereo/scene_planes.h"

namespace vitrine {

// Planes in addition to `planes` (scene_planes()), at most six, those with the largest gain first. Call count_agreement() on
// `maps` first. The result does not depend on the number of threads.
std::vector<ScenePlane> bare_walls(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps,
                                   std::span<const ScenePlane> planes);

}  // namespace vitrine
