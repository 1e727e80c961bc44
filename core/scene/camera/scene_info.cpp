#include "core/scene/camera/scene_info.h"

#include <cmath>
#include <stdexcept>

#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"

namespace vitrine {

namespace {

nlohmann::json json_of(const Mat3d& m) {  // rows
  const Mat3d t = transposed(m);
  return {json_of(t.c0), json_of(t.c1), json_of(t.c2)};
}

Mat3d mat3_of(const nlohmann::json& j) {
  if (!j.is_array() || j.size() != 3) throw std::invalid_argument("expected three rows of three numbers");
  return transposed(Mat3d{vec3_of(j[0]), vec3_of(j[1]), vec3_of(j[2])});
}

}  // namespace

SceneInfo read_scene_info(const fs::path& path) {
  SceneInfo s;
  read_json_file(path, "scene description", [&](const nlohmann::json& j) {
    const nlohmann::json& frame = j.at("scene_from_colmap");
    s.scene_from_colmap = {frame.at("scale").get<double>(), mat3_of(frame.at("rotation")), vec3_of(frame.at("translation"))};
    if (!(s.scene_from_colmap.scale > 0) || std::abs(determinant(s.scene_from_colmap.rotation) - 1) > 1e-3)
      throw std::invalid_argument("scene_from_colmap is not a similarity");
    s.up = vec3_of(j.at("up"));
    s.radius = j.at("radius").get<double>();
    s.bounds = {vec3_of(j.at("bounds").at("low")), vec3_of(j.at("bounds").at("high"))};
    s.color_space = j.at("color_space").get<std::string>();
    s.scale_known = j.at("scale_known").get<bool>();
  });
  return s;
}

void write_scene_info(const fs::path& path, const SceneInfo& s) {
  write_json_file(path, {{"scene_from_colmap",
                          {{"scale", s.scene_from_colmap.scale},
                           {"rotation", json_of(s.scene_from_colmap.rotation)},
                           {"translation", json_of(s.scene_from_colmap.translation)}}},
                         {"up", json_of(s.up)},
                         {"radius", s.radius},
                         {"bounds", {{"low", json_of(s.bounds.low)}, {"high", json_of(s.bounds.high)}}},
                         {"color_space", s.color_space},
                         {"scale_known", s.scale_known}});
}

Gains read_gains(const fs::path& path) {
  Gains gains;
  read_json_file(path, "list of gains", [&](const nlohmann::json& j) {
    for (const auto& [name, value] : j.items()) {
      const Vec3d g = vec3_of(value);
      if (!(g.x > 0) || !(g.y > 0) || !(g.z > 0)) throw std::invalid_argument("the gain of '" + name + "' is not positive");
      gains.emplace(name, g);
    }
  });
  return gains;
}

void write_gains(const fs::path& path, const Gains& gains) {
  nlohmann::json j = nlohmann::json::object();
  for (const auto& [name, gain] : gains) j[name] = json_of(gain);
  write_json_file(path, j);
}

}  // namespace vitrine
