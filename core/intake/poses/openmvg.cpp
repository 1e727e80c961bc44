// Format: OpenMVG, src/openMVG/sfm/sfm_data_io_cereal.hpp and cameras/*.hpp; polymorphic objects as cereal writes them: an id
// with the highest bit set has a name, later objects of the same type have that id without the bit.
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/foundation/config/json_file.h"
#include "core/intake/poses/program_poses.h"

namespace vitrine {

namespace {

constexpr uint64_t kNamed = uint64_t(1) << 31, kSameType = uint64_t(1) << 30, kUndefined = 4294967295;

uint64_t whole(const JsonAt& in) {
  const double v = in.number();
  if (!(v >= 0 && v <= double(kUndefined) && v == std::floor(v))) in.fail("expected an id");
  return static_cast<uint64_t>(v);
}

// The type of a polymorphic value by its name; empty for values of the declared type.
class TypeNames {
 public:
  std::string of(const JsonAt& value) {
    if (!value.has("polymorphic_id")) return {};
    const uint64_t id = whole(value.at("polymorphic_id"));
    if (id == kSameType) return {};
    if (id & kNamed) return names_[id & ~kNamed] = value.at("polymorphic_name").text();
    const auto known = names_.find(id);
    if (known == names_.end()) value.at("polymorphic_id").fail("no value before it has this id and a name");
    return known->second;
  }

 private:
  std::map<uint64_t, std::string> names_;
};

JsonAt data_of(const JsonAt& value) { return value.has("ptr_wrapper") ? value.at("ptr_wrapper").at("data") : value; }

// A member of the object or of its base classes, which cereal nests as "value0".
JsonAt member(const JsonAt& data, const char* key) {
  constexpr int kDeepest = 3;
  JsonAt at = data;
  for (int i = 0; i < kDeepest && !at.has(key) && at.has("value0"); ++i) at = at.at("value0");
  return at.has(key) ? at.at(key) : data.at(key);
}

struct LensKind {
  std::string_view name;
  const char* key;  // of the list of parameters; nullptr: none
  size_t count;
};
constexpr LensKind kLenses[] = {
    {"pinhole", nullptr, 0},
    {"pinhole_radial_k1", "disto_k1", 1},  // k1
    {"pinhole_radial_k3", "disto_k3", 3},  // k1 k2 k3
    {"pinhole_brown_t2", "disto_t2", 5},   // k1 k2 k3 t1 t2
};

ColmapCamera openmvg_camera(const JsonAt& value, const std::string& type) {
  const LensKind* kind = nullptr;
  for (const LensKind& k : kLenses)
    if (k.name == type) kind = &k;
  if (kind == nullptr)
    value.fail(
        fmt::format("the camera is '{}'; supported are pinhole, pinhole_radial_k1, pinhole_radial_k3 and "
                    "pinhole_brown_t2: undistort the photos first",
                    type.substr(0, 40)));
  const JsonAt data = data_of(value), centre = member(data, "principal_point");
  const double width = member(data, "width").number(), height = member(data, "height").number();
  if (!(width >= 1 && height >= 1 && std::max(width, height) <= 1 << 20)) data.fail("width and height are no size in pixels");
  const double focal = member(data, "focal_length").number();
  if (!(focal > 0)) member(data, "focal_length").fail("the focal length is not positive");
  if (centre.list("a list of two numbers").size() != 2) centre.fail("expected a list of two numbers");
  double d[5] = {};
  if (kind->key != nullptr) {
    const JsonAt list = member(data, kind->key);
    if (list.list("a list of numbers").size() != kind->count) list.fail(fmt::format("expected {} numbers", kind->count));
    for (size_t i = 0; i < kind->count; ++i) d[i] = list[i].number();
  }
  return brown_camera({int(std::lround(width)), int(std::lround(height)), focal, focal, centre[0].number(), centre[1].number()},
                      {d[0], d[1], d[2], d[3], d[4]});
}

Rigid openmvg_pose(const JsonAt& value) {
  const JsonAt rows = value.at("rotation"), centre = value.at("center");
  Mat3d rotation;
  if (rows.list("three rows of three numbers").size() != 3) rows.fail("expected three rows of three numbers");
  for (size_t r = 0; r < 3; ++r) {
    const JsonAt row = rows[r];
    if (row.list("a row of three numbers").size() != 3) row.fail("expected a row of three numbers");
    for (size_t c = 0; c < 3; ++c) rotation(r, c) = row[c].number();
  }
  if (const char* why = why_no_rotation(rotation)) rows.fail(why);
  rotation = nearest_rotation(rotation);
  if (centre.list("a list of three numbers").size() != 3) centre.fail("expected a list of three numbers");
  return {rotation, -(rotation * Vec3d{centre[0].number(), centre[1].number(), centre[2].number()})};
}

// The entries of a map as cereal writes it, by their keys.
std::map<uint64_t, JsonAt> entries(const JsonAt& top, const char* name) {
  std::map<uint64_t, JsonAt> out;
  const JsonAt list = top.at(name);
  list.list("a list of keys and values");
  for (size_t i = 0; i < list.size(); ++i) {
    const JsonAt entry = list[i];
    if (!out.emplace(whole(entry.at("key")), entry.at("value")).second) entry.fail("a key occurs twice");
  }
  return out;
}

}  // namespace

ProgramPoses read_openmvg(const std::filesystem::path& path) {
  ProgramPoses out;
  read_json_file(path, "sfm_data file of OpenMVG", [&](const nlohmann::json& document) {
    const JsonAt top(document), views = top.at("views");
    views.list("a list of views");
    TypeNames types;
    for (size_t i = 0; i < views.size(); ++i) types.of(views[i].at("value"));
    std::map<uint64_t, uint32_t> cameras;  // id_intrinsic -> camera
    // In file order: a type has its name where it first occurs.
    const JsonAt intrinsics = top.at("intrinsics");
    intrinsics.list("a list of intrinsics");
    for (size_t i = 0; i < intrinsics.size(); ++i) {
      const JsonAt value = intrinsics[i].at("value");
      const uint32_t id = camera_id_of(out.model, openmvg_camera(value, types.of(value)));
      cameras[whole(intrinsics[i].at("key"))] = id;
    }
    const std::map<uint64_t, JsonAt> poses = entries(top, "extrinsics");
    size_t without = 0;
    for (size_t i = 0; i < views.size(); ++i) {
      const JsonAt view = data_of(views[i].at("value")), intrinsic = member(view, "id_intrinsic");
      const auto pose = poses.find(whole(member(view, "id_pose")));
      if (pose == poses.end() || whole(intrinsic) == kUndefined) {
        ++without;
        continue;
      }
      const auto camera = cameras.find(whole(intrinsic));
      if (camera == cameras.end()) intrinsic.fail("there are no intrinsics with this key");
      const std::filesystem::path folder = member(view, "local_path").text();
      add_pose(out, openmvg_pose(pose->second), camera->second, (folder / member(view, "filename").text()).string(),
               fmt::format("views[{}]", i));
    }
    if (out.model.images.empty())
      top.at("extrinsics").fail("no view has a pose: it is the list of photos, before reconstruction");
    if (without > 0) out.notes.push_back({"", fmt::format("{} of {} views of the file have no pose", without, views.size())});
  });
  return out;
}

}  // namespace vitrine
