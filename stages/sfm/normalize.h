// Scene frame: up = +z, camera centroid at 0, 95 % of the cameras within radius 1 (core/conventions.md).
// gps_frame.h determines up and east from GPS coordinates, where there are any.
#pragma once

#include <array>
#include <string_view>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

enum class UpMethod { Auto, Level, Ring, Mean, Nadir };
inline constexpr std::array<std::string_view, 5> kUpMethodWords{"auto", "level", "ring", "mean", "nadir"};

struct Orientation {
  Vec3d up;         // unit, in the frame of the model
  UpMethod method;  // never Auto
};

// Up vector of the scene. Photos are upright (EXIF applied) and people hold cameras level, so the right vectors x_i of the
// cameras are horizontal:
//   up = argmin sum_i w_i (x_i . up)^2       (smallest eigenvector, re-weighted against tilted shots; sign from the mean up
//   vector).
// When all cameras look the same way this is one direction short, and the mean up vector decides. Cameras in a flat ring
// around the scene refine it with the normal of their plane. Views straight down (drones) have no up of their own: up = -mean
// forward. `method`: Auto, or one of the four to insist.
Orientation scene_up(const ColmapModel& model, UpMethod method = UpMethod::Auto);
// +x is the horizontal part of `east`, or without it the direction from the centroid to the first camera.
Similarity scene_from_colmap(const ColmapModel& model, const Orientation& orientation, const Vec3d& east = {});

}  // namespace vitrine
