// Depth and normal of every pixel of the training photos, before anything is trained: PatchMatch stereo on reduced photos
// (core/observe/stereo/patch_match.h), with the sparse points as hints.
#pragma once

#include <vector>

#include "core/observe/stereo/scene_planes.h"
#include "core/learn/trainer/capture.h"

namespace vitrine {

struct DenseDepth {
  std::vector<StereoPhoto> photos;  // [capture.photos]; without a picture for held-out photos
  std::vector<DepthMap> maps;       // same order; empty where no other photo confirms a pixel
  std::vector<ScenePlane> planes;   // the large ones
  size_t level = 0;                 // of the pyramids: as large as the maps
  double background = 0;            // distance of what has no parallax: the sky; radii of the cameras
  double reliable_share() const;    // of all pixels
};

// Works at the pyramid level whose longer side comes nearest to `max_side`.
DenseDepth dense_depth(const Capture& capture, int max_side, double far_factor, uint64_t seed);

}  // namespace vitrine
