// Detects the large planes of a scene (floor, walls, table) in the reliable pixels of all photos. Where stereo finds no depth,
// one of these planes is a better estimate than an extrapolation of a few noisy pixels. Greedy: the plane with the most support
// among the planes fitted around single pixels, refined by least squares, then the next (Schnabel et al., "Efficient RANSAC for
// Point-Cloud Shape Detection", 2007, without random sampling).
#pragma once

#include <limits>

#include "core/observe/stereo/patch_match.h"

namespace vitrine {

struct ScenePlane {
  Vec3d normal;        // world frame, unit
  double offset = 0;   // normal.X = offset
  double share = 0;    // of the surface that stereo found in all photos
  Vec3d centre{};      // of its supporting points
  double extent = 0;   // root mean square distance of these points from the centre
  bool floor = false;  // horizontal, below all cameras, with no surface found below it: no ray continues behind it

  // Distance from the centre up to which the plane is extrapolated: a facet of a round object is no wall. A floor is unbounded,
  // since no photo sees through it.
  double reach() const { return floor ? std::numeric_limits<double>::infinity() : 3.5 * extent; }
};

// Largest first, at most twelve, each at least a hundredth of the surface found. Call count_agreement() on `maps` first.
std::vector<ScenePlane> scene_planes(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps);

// A plane in image space: inverse depth is affine in the pixel, 1/z = a x + b y + c, so that fitting a plane to a depth map is
// a least-squares fit of three parameters.
struct InversePlane {
  double a = 0, b = 0, c = 0;  // x, y are pixel centres
  double at(double x, double y) const { return a * x + b * y + c; }
};

// From {X : normal.X = offset} in the camera frame.
InversePlane inverse_plane(const Intrinsics& k, const Vec3d& normal, double offset);
// Normal in the camera frame, towards the camera.
Vec3d normal_towards_camera(const Intrinsics& k, const InversePlane& plane);

// Fits a plane to the reliable pixels within 10 pixels of the reliable pixel (x, y) that lie on its own plane, then refits it
// to those on the fitted plane. Returns the pixel's own plane where the fit is underdetermined.
InversePlane fitted_plane(const Intrinsics& k, const DepthMap& map, int x, int y);

// Plane sweep for textureless walls and floors, which scene_planes.h misses because stereo finds no depth in their middle.
// Borders and shading constrain them: warped through the correct plane, pixels without reliable depth match the other photos
// better than at any other depth or at infinity. The search covers planes that bound all cameras and all stereo points: vertical
// walls, and a floor where stereo found none. A plane is accepted only if moving or turning it makes the match worse, which
// rejects the sky.

// Planes in addition to `planes` (scene_planes()), at most six, those with the largest gain first. Call count_agreement() on
// `maps` first. The result does not depend on the number of threads.
std::vector<ScenePlane> bare_walls(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps,
                                   std::span<const ScenePlane> planes);

// Fills the pixels of a depth map that stereo left unreliable (a wall behind an object, a border that only one photo sees,
// textureless plaster). Candidates per pixel: the planes of the nearest reliable pixels (nearest along paths that avoid
// brightness edges, so that a wall is extended from the wall and not from the vase in front of it), a large plane of the scene
// within a few of its own extents, or the far background (the sky above the wall, at background_z). The cost is the brightness
// residual in the other photos plus a penalty for occluding their reliable surfaces; costs are filtered over similar pixels and
// the cheapest candidate is used (Hosni et al., "Fast Cost-Volume Filtering for Visual Correspondence and Beyond", 2013).

// The map of photo `index` with zdepth and normal replaced where pixels are not reliable(). A map without reliable pixels is
// returned unchanged.
DepthMap extended(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps, std::span<const ScenePlane> planes,
                  size_t index);

}  // namespace vitrine
