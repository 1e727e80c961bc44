// scene.json and sfm/gains.json of an sfm artifact: the frame of the scene, and what each photo's exposure and white balance
// do to it (linear photo = gain * radiance, per channel).
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "core/foundation/math/rigid.h"

namespace vitrine {

struct SceneInfo {
  Similarity scene_from_colmap;  // undo with its inverse: the frame of COLMAP's own model
  Vec3d up{0, 0, 1};
  double radius = 1;  // 95th percentile distance of the cameras from their centroid
  Bounds3 bounds;     // of the sparse points
  std::string color_space = "lin_rec709";
  bool scale_known = false;  // true when one unit has a length in metres behind it
};

SceneInfo read_scene_info(const std::filesystem::path& path);
void write_scene_info(const std::filesystem::path& path, const SceneInfo& scene);

using Gains = std::map<std::string, Vec3d>;  // view name -> gain of r, g, b; all positive
Gains read_gains(const std::filesystem::path& path);
void write_gains(const std::filesystem::path& path, const Gains& gains);

}  // namespace vitrine
