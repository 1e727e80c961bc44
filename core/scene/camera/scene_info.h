// scene.json and sfm/gains.json of an sfm artifact: the scene frame, and exposure and white balance of each photo (linear photo
// = gain * radiance, per channel).
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "core/foundation/math/rigid.h"

namespace vitrine {

struct SceneInfo {
  Similarity scene_from_colmap;  // its inverse gives COLMAP's frame
  Vec3d up{0, 0, 1};
  double radius = 1;  // 95th percentile distance of the cameras from their centroid
  Bounds3 bounds;     // of the sparse points
  std::string color_space = "lin_rec709";
  bool scale_known = false;  // one unit corresponds to a known length in metres
};

SceneInfo read_scene_info(const std::filesystem::path& path);
void write_scene_info(const std::filesystem::path& path, const SceneInfo& scene);

using Gains = std::map<std::string, Vec3d>;  // view name -> gain of r, g, b; all positive
Gains read_gains(const std::filesystem::path& path);
void write_gains(const std::filesystem::path& path, const Gains& gains);

}  // namespace vitrine
