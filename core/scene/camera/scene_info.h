// scene.json and sfm/gains.json of an sfm artifact: the scene frame, and exposure and white balance of each photo (linear photo
// = gain * radiance, per channel).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/foundation/math/rigid.h"

namespace vitrine {

// Place of the scene's origin on the earth (WGS84) where GPS coordinates of the photos determined the frame: +x is then east, +y
// north.
struct GeoOrigin {
  double latitude = 0, longitude = 0;   // degrees, north and east positive
  std::optional<double> altitude = {};  // metres above sea level, as receivers write it
  double metres_per_unit = 1;           // of the scene
};
nlohmann::json json_of(const GeoOrigin& origin);
// Adds the field enu_origin to a transforms.json; other readers skip it.
void add_geo_origin(const std::filesystem::path& transforms_json, const GeoOrigin& origin);

struct SceneInfo {
  Similarity scene_from_colmap;  // its inverse gives COLMAP's frame
  Vec3d up{0, 0, 1};
  double radius = 1;  // 95th percentile distance of the cameras from their centroid
  Bounds3 bounds;     // of the sparse points
  std::string color_space = "lin_rec709";
  bool scale_known = false;      // one unit corresponds to a known length in metres
  std::optional<GeoOrigin> geo;  // a known place has a known scale

  // Metres of a scene unit; nullopt: unknown. Without GPS the frame of the poses is in metres if their scale is known.
  std::optional<double> metres_per_unit() const {
    if (geo) return geo->metres_per_unit;
    return scale_known ? std::optional(1 / scene_from_colmap.scale) : std::nullopt;
  }
};

SceneInfo read_scene_info(const std::filesystem::path& path);
void write_scene_info(const std::filesystem::path& path, const SceneInfo& scene);

using Gains = std::map<std::string, Vec3d>;  // view name -> gain of r, g, b; all positive
Gains read_gains(const std::filesystem::path& path);
void write_gains(const std::filesystem::path& path, const Gains& gains);

// Capture passes, sfm/passes.json of an sfm artifact: groups of photos between which the object was moved relative to its
// surroundings (for example turned over), and the reference frame of the poses.

using Passes = std::vector<std::vector<std::string>>;  // photo names, largest pass first

enum class PosesOf {
  Object,       // the object is fixed; the surroundings move between passes
  LargestPass,  // only photos of the largest pass have poses: the passes share too few object features
  Surroundings  // surroundings or object, unknown without masks; the other one moves between passes
};

// Passes between which the surroundings moved relative to the poses. Empty if there are none or the poses do not follow the
// object. Throws Error{Input} if the file is damaged.
Passes read_passes(const std::filesystem::path& sfm_artifact);
void write_passes(const std::filesystem::path& sfm_artifact, const Passes& passes, PosesOf poses);

// Sentence for the user; empty if there are no passes.
std::string passes_summary(const std::filesystem::path& sfm_artifact);
// Index of the pass that contains the photo; 0 without passes, passes.size() if not found.
size_t pass_of(const Passes& passes, const std::string& photo);

// "2 passes: 34 and 18 photos"
std::string passes_text(const Passes& passes);

}  // namespace vitrine
