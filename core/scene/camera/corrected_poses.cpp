#include "core/scene/camera/corrected_poses.h"

#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"

namespace vitrine {

namespace {

constexpr double kUnitWithin = 1e-6;  // of the length of a quaternion

fs::path poses_path(const fs::path& optimize_folder) { return optimize_folder / "optimize" / "poses.json"; }

nlohmann::json json_of(const Rigid& cam_from_world) {
  const Quatd q = quaternion(cam_from_world.rotation);
  return {{"rotation", {q.w, q.x, q.y, q.z}}, {"translation", vitrine::json_of(cam_from_world.translation)}};
}

Rigid pose_of(const nlohmann::json& j, const std::string& name) {
  const nlohmann::json& r = j.at("rotation");
  if (!r.is_array() || r.size() != 4) throw std::invalid_argument("the rotation of '" + name + "' is not w, x, y, z");
  const Quatd q{r[0].get<double>(), r[1].get<double>(), r[2].get<double>(), r[3].get<double>()};
  if (!(std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < kUnitWithin))
    throw std::invalid_argument("the rotation of '" + name + "' is no unit quaternion");
  return {rotation_matrix(normalized(q)), vec3_of(j.at("translation"))};
}

}  // namespace

void write_corrected_poses(const fs::path& optimize_folder, const std::vector<View>& views) {
  nlohmann::json poses = nlohmann::json::object();
  for (const View& view : views) poses[view.name] = json_of(view.cam_from_world);
  write_json_file(poses_path(optimize_folder), {{"cam_from_world", poses}});
}

bool has_corrected_poses(const fs::path& optimize_folder) { return fs::exists(poses_path(optimize_folder)); }

void correct_poses(const fs::path& optimize_folder, std::vector<View>& views) {
  if (!has_corrected_poses(optimize_folder)) return;
  const fs::path path = poses_path(optimize_folder);
  std::map<std::string, Rigid> poses;
  read_json_file(path, "list of corrected poses", [&](const nlohmann::json& j) {
    for (const auto& [name, pose] : j.at("cam_from_world").items()) poses.emplace(name, pose_of(pose, name));
  });
  for (View& view : views)
    if (const auto found = poses.find(view.name); found != poses.end()) view.cam_from_world = found->second;
}

ViewSet load_view_set(const fs::path& sfm_folder, const fs::path& optimize_folder) {
  ViewSet set = load_view_set(sfm_folder);
  correct_poses(optimize_folder, set.views);
  return set;
}

}  // namespace vitrine
