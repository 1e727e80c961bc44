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

}  // namespace vitrine
