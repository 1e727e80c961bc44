// The large planes of a scene (floor, walls, table), found in the reliable pixels of all photos together. What people build is
// flat: where stereo finds nothing, one of these planes is a better guess than any continuation of a few noisy pixels.
// Found one after the other: the plane with the most support among the planes fitted around single pixels, refined by least
// squares (Schnabel et al., "Efficient RANSAC for Point-Cloud Shape Detection", 2007, without the chance).
#pragma once

#include <limits>

#include "core/observe/stereo/patch_match.h"

namespace vitrine {

struct ScenePlane {
  Vec3d normal;        // world frame, unit
  double offset = 0;   // normal.X = offset
  double share = 0;    // of the surface that stereo found in all photos
  Vec3d centre{};      // of what was found of it
  double extent = 0;   // root of the mean squared distance from there
  bool floor = false;  // level, below all cameras, and nothing was found below it: no ray goes on behind it

  // How far from its centre it stands to reason that the plane goes on: a facet of something round is no wall. A floor ends
  // nowhere, as nothing is seen through it.
  double reach() const { return floor ? std::numeric_limits<double>::infinity() : 3.5 * extent; }
};

// Largest first, at most twelve, each at least a hundredth of the surface found. `maps` after count_agreement().
std::vector<ScenePlane> scene_planes(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps);

// A plane as a photo sees it: inverse depth is affine in the pixel, 1/z = a x + b y + c, so that fitting a plane to a depth map
// is a least-squares fit of three numbers.
struct InversePlane {
  double a = 0, b = 0, c = 0;  // of pixels: x, y are pixel centres
  double at(double x, double y) const { return a * x + b * y + c; }
};

// {X : normal.X = offset} of the camera frame.
InversePlane inverse_plane(const Intrinsics& k, const Vec3d& normal, double offset);
// Its normal in the camera frame, towards the camera.
Vec3d normal_towards_camera(const Intrinsics& k, const InversePlane& plane);

// Fitted to the reliable pixels within 10 pixels of the reliable pixel (x, y) that lie on its own plane, then on the fitted one.
// The pixel's own plane where they do not fix one.
InversePlane fitted_plane(const Intrinsics& k, const DepthMap& map, int x, int y);

}  // namespace vitrine
