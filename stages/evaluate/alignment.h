// Brings our world into the truth's: a similarity over the camera centres (Umeyama 1991), then pose errors in the truth's units.
// With c_i our centres, t_i the truth's, minimise sum |s R c_i + t - t_i|^2: R from the SVD of the covariance, s from its trace.
// Badly placed cameras must not tilt the whole scene: a least-median start finds the crowd, the fit uses the crowd alone.
// Centres on a line leave the turn about that line open; then R is the mean of the cameras' own relative rotations.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine {

// Least squares over all pairs. Needs at least two distinct points; `from` and `to` have the same size.
Similarity umeyama(std::span<const Vec3d> from, std::span<const Vec3d> to);

struct CameraPair {
  Rigid ours;   // cam_from_world
  Rigid truth;  // cam_from_world, truth frame
};

struct Alignment {
  Similarity truth_from_ours;
  size_t used = 0;               // cameras in the last fit
  bool by_orientations = false;  // centres were on a line
};
// Needs two cameras with distinct centres; throws Error{Input} otherwise (`where` names the truth file).
Alignment align_cameras(std::span<const CameraPair> cameras, const std::string& where);

struct PoseError {
  double rotation_deg = 0;  // angle between the camera's two orientations after the alignment
  double centre_rel = 0;    // distance of the centres / ring radius
};
std::vector<PoseError> pose_errors(std::span<const CameraPair> cameras, const Similarity& truth_from_ours);
// 95th percentile of the distance of the cameras from their centroid (core/conventions.md).
double ring_radius(std::span<const CameraPair> cameras);

double rotation_angle_deg(const Mat3d& a, const Mat3d& b);  // of a b^T, exact for small angles too

}  // namespace vitrine
