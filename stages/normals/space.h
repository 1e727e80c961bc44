// Coordinate frames of normal maps, and their detection. Predictors and files differ in the signs of their axes; the eight sign
// combinations (and the world frame) are compared with normals from the geometry of the photos.
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
  bool world = false;    // scene frame; all signs are +

  Vec3f in_camera(const Vec3f& n, const Rigid& cam_from_world) const;
  std::string name() const;  // "camera-opencv", ..., else "camera, axes x- y+ z+"
};

// Accepted names: camera-opencv, camera-opengl, camera-left-up-back, world.
std::vector<std::string> normal_space_names();
NormalSpace normal_space(std::string_view name);
// Converts `map` to the camera frame.
void to_camera(NormalMap& map, const NormalSpace& space, const Rigid& cam_from_world);

struct SpaceSample {
  const NormalMap& given;      // in the unknown frame
  const NormalMap& geometric;  // camera frame; same size
  const View& view;            // intrinsics of that size
};
struct SpaceCandidate {
  NormalSpace space;
  double error_deg = 0;  // mean angle to the geometric normals
  double facing = 0;     // share of normals facing the camera
};
// Best first. Throws Error{Input} naming `what` when too few pixels are comparable, the best is off by more than 40 degrees, or
// the second is equally good: a sign is not determined by the photos.
std::vector<SpaceCandidate> detected_space(std::span<const SpaceSample> samples, const std::string& what);

}  // namespace vitrine
