// Formats and formulas: documentation of OpenSfM, "Reconstruction file format" and "Geometric models".
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/foundation/config/json_file.h"
#include "core/intake/poses/program_poses.h"

namespace vitrine {

namespace {

double number_or(const JsonAt& in, const char* key, double otherwise) { return in.has(key) ? in.at(key).number() : otherwise; }

ColmapCamera opensfm_camera(const JsonAt& in) {
  const JsonAt type = in.at("projection_type");
  const std::string name = type.text();
  if (name != "perspective" && name != "brown" && name != "simple_radial" && name != "radial")
    type.fail("the camera is '" + name.substr(0, 40) +
              "'; supported are perspective, simple_radial, radial and brown: undistort the photos first");
  const double width = in.at("width").number(), height = in.at("height").number(), size = std::max(width, height);
  if (!(width >= 1 && height >= 1 && size <= 1 << 20)) in.fail("width and height are no size in pixels");
  const double fx = in.has("focal_x") ? in.at("focal_x").number() : in.at("focal").number();
  const double fy = number_or(in, "focal_y", fx);
  if (!(fx > 0 && fy > 0)) in.fail("the focal length is not positive");
  return brown_camera(
      {int(std::lround(width)), int(std::lround(height)), fx * size, fy * size, number_or(in, "c_x", 0) * size + 0.5 * width,
       number_or(in, "c_y", 0) * size + 0.5 * height},
      {number_or(in, "k1", 0), number_or(in, "k2", 0), number_or(in, "k3", 0), number_or(in, "p1", 0), number_or(in, "p2", 0)});
}

Vec3d three_numbers(const JsonAt& in) {
  if (in.list("a list of three numbers").size() != 3) in.fail("expected a list of three numbers");
  return {in[0].number(), in[1].number(), in[2].number()};
}

// direction = axis, length = angle in radians
Mat3d rotation_about(const Vec3d& vector) {
  const double angle = length(vector);
  if (!(angle > 0)) return Mat3d::identity();
  const Vec3d v = std::sin(0.5 * angle) / angle * vector;
  return rotation_matrix(normalized(Quatd{std::cos(0.5 * angle), v.x, v.y, v.z}));
}

size_t shot_count(const JsonAt& reconstruction) {
  const JsonAt shots = reconstruction.at("shots");
  if (!shots.value().is_object()) shots.fail("expected an object of shots");
  return shots.size();
}

// Separate reconstructions have no common frame.
JsonAt largest_reconstruction(const JsonAt& top, Notes& notes) {
  if (top.value().is_object()) return top;
  if (top.list("a list of reconstructions").size() == 0) top.fail("it has no reconstruction");
  size_t best = 0;
  std::string sizes;
  for (size_t i = 0; i < top.size(); ++i) {
    const size_t n = shot_count(top[i]);
    sizes += fmt::format("{}{}", i == 0 ? "" : ", ", n);
    if (n > shot_count(top[best])) best = i;
  }
  if (top.size() > 1)
    notes.push_back(
        {"POSES_SEVERAL", fmt::format("the file holds {} reconstructions that are not joined, of {} shots: the largest "
                                      "is read",
                                      top.size(), sizes)});
  return top[best];
}

}  // namespace

ProgramPoses read_opensfm(const std::filesystem::path& path) {
  ProgramPoses out;
  read_json_file(path, "reconstruction of OpenSfM", [&](const nlohmann::json& document) {
    const JsonAt reconstruction = largest_reconstruction(JsonAt(document), out.notes);
    if (shot_count(reconstruction) == 0) reconstruction.at("shots").fail("it has no shots");
    const JsonAt shots = reconstruction.at("shots"), cameras = reconstruction.at("cameras");
    for (const auto& entry : shots.value().items()) {
      const JsonAt shot = shots.at(entry.key().c_str());
      const ColmapCamera camera = opensfm_camera(cameras.at(shot.at("camera").text().c_str()));
      add_pose(out, {rotation_about(three_numbers(shot.at("rotation"))), three_numbers(shot.at("translation"))},
               camera_id_of(out.model, camera), entry.key(), "shot");
    }
  });
  return out;
}

}  // namespace vitrine
