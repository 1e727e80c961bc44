// What stands behind an object, as the photos show it that see past the object: a pixel that shows the same does not show the
// object. It needs no colour model and no texture of the object, which may be a mirror, only surroundings that stand still.
//
// The surface behind a pixel is not known where the object hides it, but there are few choices: the nearest surface that stereo
// found from other photos, the large planes of the scene, and the far background. Each is coloured by the median of the photos
// that see it past the object, and the one that explains the pixel and those around it best counts. (Background subtraction with
// a background from other views; compare Lee, Woo, Boyer, "Silhouette Segmentation in Multiple Views", PAMI 2011.)
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/observe/stereo/edge_field.h"
#include "core/observe/stereo/scene_planes.h"
#include "core/observe/stereo/stereo_photos.h"
#include "core/observe/stereo/visual_hull.h"

namespace vitrine {

// The scene without the object; refers to its parts.
struct Surroundings {
  std::span<const EdgePhoto> photos;
  std::span<const DepthMap> maps;      // [photo] of the size of the photos; without depths: nothing is known of that photo
  std::span<const ScenePlane> planes;  // scene_planes()
  double far = kWithoutParallax;
};

// Where the rays of a photo pass a hull: z-depths, [h*w], 0 where they do not.
struct HullDepths {
  std::vector<float> entry, exit;
};
HullDepths hull_depths(const VisualHull& hull, const View& view);

// What explains the pixels of photo `index` best, with nothing taken away: what stereo found, the large planes, the far
// background. What mirrors, and what stereo cannot find, is explained by none of them. [h,w]; where no other photo tells: -1, 0.
struct Explanation {
  std::vector<float> error, around;  // of the pixel, as of unexplained(); the mean of those around it
  std::vector<float> depth;          // z-depth of what explains it
};
Explanation explanation(const Surroundings& scene, size_t index);

// How far each pixel of photo `index` is from all that can stand behind the hull: 0 = it shows what is behind, 1 = it differs as
// much as prediction and noise allow, [h,w]. -1 outside the hull's silhouette, and where no other photo tells what is behind.
// `passed`: hull_depths() of all photos.
std::vector<float> unexplained(const Surroundings& scene, const VisualHull& hull, std::span<const HullDepths> passed,
                               size_t index);

// [h,w] 1 where stereo found a surface in front of the hull.
std::vector<uint8_t> hidden_pixels(const DepthMap& map, const HullDepths& passed);

// The sides of the large planes that the cameras are on, of those that the hull reaches through: a thing stands on a table, not
// in it. Of nearly parallel planes the one that leaves the most.
std::vector<HalfSpace> sides_of_cameras(std::span<const ScenePlane> planes, std::span<const View> views, const Bounds3& hull);

}  // namespace vitrine
