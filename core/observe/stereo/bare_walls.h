// Bare walls and the floor: planes without texture, which stereo does not find (scene_planes.h), because nothing in their middle
// tells one depth from another. Their borders do, and so does their shading: carried through the right plane, what a photo shows
// where it has no reliable depth agrees with the other photos better than at any other depth, or infinitely far away. They are
// looked for only where they bound all cameras and all that stereo found, walls upright, and a floor where stereo has found none.
// One counts only if the photos refute it when it is moved or turned, which they do not for the sky.
#pragma once

#include "core/observe/stereo/scene_planes.h"

namespace vitrine {

// Beyond `planes` (scene_planes()), those that explain the most first, at most six. `maps` after count_agreement(). The same for
// any number of threads.
std::vector<ScenePlane> bare_walls(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps,
                                   std::span<const ScenePlane> planes);

}  // namespace vitrine
