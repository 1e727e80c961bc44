// The frames in which normals come, and finding out which one it was. Predictors and picture files disagree in the signs of their
// axes; the eight combinations (and the world frame) are compared with normals that the photos' geometry gives.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/camera/view.h"
#include "stages/normals/normal_map.h"

namespace vitrine {

struct NormalSpace {
  Vec3f signs{1, 1, 1};  // OpenCV camera frame = signs * axes of the space
  bool world = false;    // the axes are the scene's, and the signs all +

  Vec3f in_camera(const Vec3f& n, const Rigid& cam_from_world) const;
  std::string name() const;  // "camera-opencv", ..., else "camera, axes x- y+ z+"
};

// Names that can be declared: camera-opencv, camera-opengl, camera-left-up-back, world.
std::vector<std::string> normal_space_names();
NormalSpace normal_space(std::string_view name);
// Writes all of `map` in the camera's frame.
void to_camera(NormalMap& map, const NormalSpace& space, const Rigid& cam_from_world);

struct SpaceSample {
  const NormalMap& given;      // in the unknown space
  const NormalMap& geometric;  // camera frame; same size
  const View& view;            // intrinsics of that size
};
struct SpaceCandidate {
  NormalSpace space;
  double error_deg = 0;  // mean angle to the geometric normals
  double facing = 0;     // share that looks at the camera
};
// Best first. Throws Error{Input} naming `what` when too few pixels can be compared, the best is off by more than 40 degrees, or
// the second is as good: a sign that nothing in the photos decides.
std::vector<SpaceCandidate> detected_space(std::span<const SpaceSample> samples, const std::string& what);

}  // namespace vitrine
