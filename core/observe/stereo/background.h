// Background prediction behind an object from photos that see past the object. A pixel that matches the predicted background
// does not show the object. Needs no colour model and no texture of the object, which may be a mirror; the surroundings must be
// static.
//
// The hidden background surface is one of few candidates: the nearest surface that stereo found from other photos, the large
// planes of the scene, the far background. Each is coloured by the median of the photos that see it past the object; the
// candidate that best explains the pixel and its neighbours is used. (Background subtraction with a background from other views;
// compare Lee, Woo, Boyer, "Silhouette Segmentation in Multiple Views", PAMI 2011.)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/observe/stereo/edge_field.h"
#include "core/observe/stereo/patch_match.h"
#include "core/observe/stereo/scene_planes.h"
#include "core/observe/stereo/visual_hull.h"

namespace vitrine {

// The scene without the object. Holds references.
struct Surroundings {
  std::span<const EdgePhoto> photos;
  std::span<const DepthMap> maps;      // [photo] of the size of the photos; an empty map = no depths for that photo
  std::span<const ScenePlane> planes;  // scene_planes()
  double far = kWithoutParallax;
};

// z-depths at which the rays of a photo enter and leave a visual hull, [h*w]; 0 where they miss it.
struct HullDepths {
  std::vector<float> entry, exit;
};
HullDepths hull_depths(const VisualHull& hull, const View& view);

// The best candidate for each pixel of photo `index` with no object removed: stereo surface, large plane or far background.
// Mirrors, and surfaces that stereo does not find, keep a high error. [h,w]; -1, 0 where no other photo sees the candidates.
struct Explanation {
  std::vector<float> error, around;  // error of the pixel, as for unexplained(); mean error of its neighbourhood
  std::vector<float> depth;          // z-depth of the best candidate
};
Explanation explanation(const Surroundings& scene, size_t index);

// Difference of each pixel of photo `index` from all background candidates behind the visual hull: 0 = background, 1 = the
// difference that prediction error and noise allow, [h,w]. -1 outside the hull's silhouette and where no other photo sees the
// background. `passed`: hull_depths() of all photos.
std::vector<float> unexplained(const Surroundings& scene, const VisualHull& hull, std::span<const HullDepths> passed,
                               size_t index);

// [h,w] 1 where stereo found a surface in front of the visual hull.
std::vector<uint8_t> hidden_pixels(const DepthMap& map, const HullDepths& passed);

// Half-spaces that contain the cameras, for the large planes that cut the visual hull: an object stands on a table, not in it. Of
// nearly parallel planes, the one that keeps the largest part of the hull.
std::vector<HalfSpace> sides_of_cameras(std::span<const ScenePlane> planes, std::span<const View> views, const Bounds3& hull);

}  // namespace vitrine
