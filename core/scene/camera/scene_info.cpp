#include "core/scene/camera/scene_info.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

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

GeoOrigin geo_of(const nlohmann::json& j) {
  GeoOrigin g{.latitude = j.at("latitude").get<double>(), .longitude = j.at("longitude").get<double>()};
  if (j.contains("altitude")) g.altitude = j.at("altitude").get<double>();
  g.metres_per_unit = j.at("metres_per_unit").get<double>();
  if (!(std::abs(g.latitude) <= 90) || !(std::abs(g.longitude) <= 180) || !(g.metres_per_unit > 0))
    throw std::invalid_argument("enu_origin is not a place with a scale");
  return g;
}

}  // namespace

nlohmann::json json_of(const GeoOrigin& g) {
  nlohmann::json j{{"latitude", g.latitude},
                   {"longitude", g.longitude},
                   {"metres_per_unit", g.metres_per_unit},
                   {"axes", "x east, y north, z up"}};
  if (g.altitude) j["altitude"] = *g.altitude;
  return j;
}

void add_geo_origin(const fs::path& transforms_json, const GeoOrigin& origin) {
  nlohmann::json document;
  read_json_file(transforms_json, "transforms.json", [&](const nlohmann::json& j) { document = j; });
  document["enu_origin"] = json_of(origin);
  write_json_file(transforms_json, document);
}

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
    if (j.contains("enu_origin")) s.geo = geo_of(j.at("enu_origin"));
  });
  return s;
}

void write_scene_info(const fs::path& path, const SceneInfo& s) {
  nlohmann::json j = {{"scene_from_colmap",
                       {{"scale", s.scene_from_colmap.scale},
                        {"rotation", json_of(s.scene_from_colmap.rotation)},
                        {"translation", json_of(s.scene_from_colmap.translation)}}},
                      {"up", json_of(s.up)},
                      {"radius", s.radius},
                      {"bounds", {{"low", json_of(s.bounds.low)}, {"high", json_of(s.bounds.high)}}},
                      {"color_space", s.color_space},
                      {"scale_known", s.scale_known}};
  if (s.geo) j["enu_origin"] = json_of(*s.geo);
  write_json_file(path, j);
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

namespace {

fs::path passes_path(const fs::path& sfm_artifact) { return sfm_artifact / "sfm" / "passes.json"; }

constexpr const char* kPosesOf[] = {"object", "largest_pass", "surroundings"};
constexpr const char* kSummaries[] = {"the object was moved between them, and the poses are those of the object",
                                      "they share too little of the object, and the largest alone is reconstructed",
                                      "an object was moved between them, and the poses do not follow it: give masks of it"};

struct PassesFile {
  Passes passes;
  PosesOf poses = PosesOf::Object;
};

PassesFile read_file_of(const fs::path& sfm_artifact) {
  PassesFile file;
  if (const fs::path path = passes_path(sfm_artifact); fs::exists(path))
    read_json_file(path, "list of passes", [&](const nlohmann::json& j) {
      const auto word = std::find(std::begin(kPosesOf), std::end(kPosesOf), j.at("poses_of").get<std::string>());
      if (word == std::end(kPosesOf)) throw std::invalid_argument("poses_of must be object, largest_pass or surroundings");
      file.poses = PosesOf(word - std::begin(kPosesOf));
      for (const nlohmann::json& pass : j.at("passes")) file.passes.push_back(pass.at("photos").get<std::vector<std::string>>());
    });
  return file;
}

}  // namespace

Passes read_passes(const fs::path& sfm_artifact) {
  PassesFile file = read_file_of(sfm_artifact);
  return file.poses == PosesOf::Object ? std::move(file.passes) : Passes{};
}

void write_passes(const fs::path& sfm_artifact, const Passes& passes, PosesOf poses) {
  nlohmann::json list = nlohmann::json::array();
  for (const std::vector<std::string>& photos : passes) list.push_back({{"photos", photos}});
  write_json_file(passes_path(sfm_artifact), {{"poses_of", kPosesOf[size_t(poses)]}, {"passes", list}});
}

std::string passes_summary(const fs::path& sfm_artifact) {
  const PassesFile file = read_file_of(sfm_artifact);
  return file.passes.empty() ? std::string() : fmt::format("{}; {}", passes_text(file.passes), kSummaries[size_t(file.poses)]);
}

size_t pass_of(const Passes& passes, const std::string& photo) {
  for (size_t i = 0; i < passes.size(); ++i)
    if (std::find(passes[i].begin(), passes[i].end(), photo) != passes[i].end()) return i;
  return passes.size();
}

std::string passes_text(const Passes& passes) {
  std::string sizes;
  for (size_t i = 0; i < passes.size(); ++i)
    sizes += fmt::format("{}{}", i == 0 ? "" : i + 1 < passes.size() ? ", " : " and ", passes[i].size());
  return fmt::format("{} passes: {} photos", passes.size(), sizes);
}

}  // namespace vitrine
