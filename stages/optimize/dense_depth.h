// Depth and normal maps of the training photos before training: PatchMatch stereo on reduced photos
// (core/observe/stereo/patch_match.h), initialised with the sparse points.
#pragma once

#include <vector>

#include "core/observe/stereo/scene_planes.h"
#include "core/learn/trainer/capture.h"

namespace vitrine {

struct DenseDepth {
  std::vector<StereoPhoto> photos;  // [capture.photos]; held-out photos have no picture
  std::vector<DepthMap> maps;       // same order; empty where no other photo confirms a pixel
  std::vector<ScenePlane> planes;   // the large ones
  size_t level = 0;                 // pyramid level of the maps
  double background = 0;            // distance of content without parallax (sky), in radii of the cameras
  double reliable_share() const;    // fraction of all pixels
};

// Uses the pyramid level whose longer side is nearest to `max_side`.
DenseDepth dense_depth(const Capture& capture, int max_side, double far_factor, uint64_t seed);

}  // namespace vitrine
