// Alignment of our world with the ground truth: a similarity over the camera centres (Umeyama 1991), then pose errors in truth
// units. With our centres c_i and the truth's t_i, minimises sum |s R c_i + t - t_i|^2: R from the SVD of the covariance, s from
// its trace. A least-median start finds the inlier cameras, and only they are fitted, so wrong poses do not tilt the scene.
// Collinear centres leave the rotation about their line undetermined; then R is the mean of the cameras' own relative rotations.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine {

// Least-squares similarity over all pairs. Needs at least two distinct points; `from` and `to` have the same size.
Similarity umeyama(std::span<const Vec3d> from, std::span<const Vec3d> to);

struct CameraPair {
  Rigid ours;   // cam_from_world
  Rigid truth;  // cam_from_world, truth frame
};

struct Alignment {
  Similarity truth_from_ours;
  size_t used = 0;               // cameras in the last fit
  bool by_orientations = false;  // the centres were collinear
};
// Needs two cameras with distinct centres; throws Error{Input} otherwise (`where` names the truth file).
Alignment align_cameras(std::span<const CameraPair> cameras, const std::string& where);

struct PoseError {
  double rotation_deg = 0;  // angle between both orientations of the camera after the alignment
  double centre_rel = 0;    // distance of the centres / ring radius
};
std::vector<PoseError> pose_errors(std::span<const CameraPair> cameras, const Similarity& truth_from_ours);
// 95th percentile of the distance of the cameras from their centroid (core/conventions.md).
double ring_radius(std::span<const CameraPair> cameras);

double rotation_angle_deg(const Mat3d& a, const Mat3d& b);  // of a b^T, exact for small angles too

}  // namespace vitrine
