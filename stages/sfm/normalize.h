// The frame of the scene: up = +z, centroid of the cameras 0, 95 % of the cameras within radius 1 (core/conventions.md).
#pragma once

#include <string>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

struct Orientation {
  Vec3d up;            // unit, in the frame of the model
  std::string method;  // "level", "ring", "mean", "nadir"
};

// Photos are upright (EXIF applied), so people hold cameras level: the right vectors x_i of the cameras are horizontal and
//   up = argmin sum_i w_i (x_i . up)^2       (smallest eigenvector, re-weighted against tilted shots; sign from the mean up
//   vector).
// When all cameras look the same way this is one direction short, and the mean up vector decides. Cameras in a flat ring
// around the scene refine it with the normal of their plane. Views straight down (drones) have no up of their own: up = -mean
// forward. `method`: "auto", or one of the four to insist.
Orientation scene_up(const ColmapModel& model, const std::string& method = "auto");
Similarity scene_from_colmap(const ColmapModel& model, const Orientation& orientation);

}  // namespace vitrine
