// Facts: Metashape Professional manual, "Camera models": x in units of f, r^2 = x^2 + y^2,
// x' = x (1 + K1 r^2 + K2 r^4 + K3 r^6 + K4 r^8) + (P1 (r^2 + 2 x^2) + 2 P2 x y) (1 + P3 r^2 + P4 r^4), y' alike, so that P1 is
// p2 of OpenCV and P2 is p1;
// u = width / 2 + cx + x' (f + B1) + y' B2, v = height / 2 + cy + y' f. Camera axes: x right, y down, z forward.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/intake/poses/program_poses.h"
#include "core/intake/poses/xml_file.h"

namespace vitrine {

namespace {

Mat3d matrix_of(const XmlFile& file, pugi::xml_node at, const std::vector<double>& n, size_t stride) {
  Mat3d m;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c) m(r, c) = n[stride * r + c];
  if (const char* why = why_no_rotation(m)) file.fail(at, fmt::format("<{}>: {}", at.name(), why));
  return nearest_rotation(m);
}

// Of a component or the chunk; empty if its place in the world is unknown.
std::optional<Similarity> place_of(const XmlFile& file, pugi::xml_node transform) {
  if (!transform.first_child()) return std::nullopt;
  Similarity s;
  if (const pugi::xml_node at = transform.child("rotation")) s.rotation = matrix_of(file, at, file.numbers(at, 9), 3);
  if (const pugi::xml_node at = transform.child("translation")) {
    const std::vector<double> t = file.numbers(at, 3);
    s.translation = {t[0], t[1], t[2]};
  }
  s.scale = file.number_of_child(transform, "scale", 1);
  if (!(s.scale > 1e-12)) file.fail(transform.child("scale"), "the scale is not positive");
  return s;
}

Rigid chunk_from_camera(const XmlFile& file, pugi::xml_node transform) {
  const std::vector<double> n = file.numbers(transform, 16);
  return {matrix_of(file, transform, n, 4), {n[3], n[7], n[11]}};
}

// Terms of the lens that the camera models of COLMAP lack.
struct HigherTerms {
  double k4 = 0, p3 = 0, p4 = 0;
};
constexpr double kInvisible = 0.2;  // pixels

// Largest distance in pixels by which the terms move a pixel of the picture.
double moved_by(const HigherTerms& higher, const BrownLens& lens, const ColmapCamera& camera, double f) {
  if (higher.k4 == 0 && higher.p3 == 0 && higher.p4 == 0) return 0;
  constexpr int kSteps = 32;
  const Intrinsics pinhole = pinhole_part(camera);
  double largest = 0;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j) {
      const Vec2d pixel{double(camera.width) * i / kSteps, double(camera.height) * j / kSteps};
      const Vec3d straight = pinhole.ray(pixel.x, pixel.y);  // where the lens without the terms folds over
      const Vec2d ray = unproject(camera, pixel).value_or(Vec2d{straight.x, straight.y});
      const double x = ray.x, y = ray.y, r2 = x * x + y * y;
      const double radial = higher.k4 * r2 * r2 * r2 * r2, tangential = higher.p3 * r2 + higher.p4 * r2 * r2;
      const double dx = x * radial + (lens.p2 * (r2 + 2 * x * x) + 2 * lens.p1 * x * y) * tangential;
      const double dy = y * radial + (lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y) * tangential;
      largest = std::max(largest, f * std::hypot(dx, dy));
    }
  return largest;
}

ColmapCamera sensor_camera(const XmlFile& file, pugi::xml_node sensor) {
  pugi::xml_node calibration = sensor.find_child_by_attribute("calibration", "class", "adjusted");
  if (!calibration) calibration = file.child(sensor, "calibration");
  for (const pugi::xml_node at : {sensor, calibration})
    if (const std::string type = at.attribute("type").as_string("frame"); type != "frame")
      file.fail(at, fmt::format("the camera type is '{}'; supported is 'frame': undistort the photos first (File > Export > "
                                "Undistort Photos)",
                                type.substr(0, 40)));
  const pugi::xml_node size =
      calibration.child("resolution") ? calibration.child("resolution") : file.child(sensor, "resolution");
  const double width = file.attribute(size, "width"), height = file.attribute(size, "height");
  if (!(width >= 1 && height >= 1 && std::max(width, height) <= 1 << 20))
    file.fail(size, "width and height are no size in pixels");
  constexpr double kSmallSkew = 1e-3;  // of the focal length: a third of a pixel over 640
  const double f = file.number(file.child(calibration, "f"));
  const auto value = [&](const char* name) { return file.number_of_child(calibration, name, 0); };
  const double fx = f + value("b1");
  if (!(f > 0 && fx > 0)) file.fail(calibration, "the focal length is not positive");
  if (const double skew = value("b2"); std::abs(skew) > kSmallSkew * f)
    file.fail(calibration.child("b2"), fmt::format("the pixels are sheared: b2 is {:.4g} for a focal length of {:.4g}", skew, f));
  const BrownLens lens{.k1 = value("k1"), .k2 = value("k2"), .k3 = value("k3"), .p1 = value("p2"), .p2 = value("p1")};
  const ColmapCamera camera = brown_camera(
      {int(std::lround(width)), int(std::lround(height)), fx, f, 0.5 * width + value("cx"), 0.5 * height + value("cy")}, lens);
  const HigherTerms higher{.k4 = value("k4"), .p3 = value("p3"), .p4 = value("p4")};
  if (const double moved = moved_by(higher, lens, camera, f); moved > kInvisible)
    file.fail(
        calibration.child(higher.k4 != 0   ? "k4"
                          : higher.p3 != 0 ? "p3"
                                           : "p4"),
        fmt::format("<k4>, <p3> and <p4> move pixels by up to {:.2g}, above {} they are not left out; supported are k1, "
                    "k2, k3, p1, p2, b1: optimise the cameras without them (Tools > Optimize Cameras), or undistort the photos",
                    moved, kInvisible));
  return camera;
}

// Cameras in file order, also those inside groups.
std::vector<pugi::xml_node> cameras_below(pugi::xml_node list) {
  pugi::xpath_node_set found = list.select_nodes(".//camera");
  found.sort();
  std::vector<pugi::xml_node> out;
  for (const pugi::xpath_node& camera : found) out.push_back(camera.node());
  return out;
}

std::string component_of(pugi::xml_node camera) { return camera.attribute("component_id").value(); }

// World from the coordinates of each component that is read. Components whose place in the world is unknown have no common
// coordinates: only the one with most cameras is read then.
std::map<std::string, Similarity> components(const XmlFile& file, pugi::xml_node chunk,
                                             const std::vector<pugi::xml_node>& aligned, Notes& notes) {
  std::map<std::string, std::optional<Similarity>> places;
  for (const pugi::xml_node component : chunk.child("components").children("component"))
    places[component.attribute("id").value()] = place_of(file, component.child("transform"));
  const std::optional<Similarity> of_chunk = place_of(file, chunk.child("transform"));
  std::map<std::string, size_t> count;
  std::vector<std::string> order;
  for (const pugi::xml_node camera : aligned)
    if (count[component_of(camera)]++ == 0) order.push_back(component_of(camera));
  if (order.size() > 1 && std::ranges::any_of(order, [&](const std::string& id) { return !places[id]; })) {
    const std::string largest = *std::ranges::max_element(order, {}, [&](const std::string& id) { return count[id]; });
    notes.push_back({"POSES_SEVERAL", fmt::format("the cameras are in {} components that are not aligned with each other: the {} "
                                                  "cameras of component '{}' are read, {} are left out",
                                                  order.size(), count[largest], largest, aligned.size() - count[largest])});
    order = {largest};
  }
  std::map<std::string, Similarity> out;
  for (const std::string& id : order) out[id] = places[id] ? *places[id] : of_chunk.value_or(Similarity{});
  // Georeferenced coordinates are millions of metres from the origin.
  const Vec3d origin = out[order.front()].translation;
  for (auto& [id, world_from_component] : out) world_from_component.translation = world_from_component.translation - origin;
  return out;
}

}  // namespace

ProgramPoses read_metashape(const fs::path& path) {
  const XmlFile file(
      path, "cameras file of Metashape",
      "in Metashape: File > Export > Export Cameras, as Agisoft XML; or as COLMAP, which holds undistorted photos, too");
  const pugi::xml_node top = file.root();
  const pugi::xml_node chunk = std::string_view(top.name()) == "chunk" ? top : file.child(top, "chunk");
  std::map<std::string, pugi::xml_node> sensors;
  for (const pugi::xml_node sensor : file.child(chunk, "sensors").children("sensor"))
    sensors.emplace(sensor.attribute("id").value(), sensor);
  const std::vector<pugi::xml_node> all = cameras_below(file.child(chunk, "cameras"));
  std::vector<pugi::xml_node> aligned;
  std::ranges::copy_if(all, std::back_inserter(aligned),
                       [](const pugi::xml_node& camera) { return bool(camera.child("transform")); });
  if (aligned.empty()) file.fail(chunk.child("cameras"), "no camera has a <transform>: align the photos first");
  ProgramPoses out;
  const std::map<std::string, Similarity> world_from = components(file, chunk, aligned, out.notes);
  std::map<std::string, uint32_t> camera_ids;
  for (const pugi::xml_node camera : aligned) {
    const auto frame = world_from.find(component_of(camera));
    if (frame == world_from.end()) continue;
    const std::string sensor = camera.attribute("sensor_id").value();
    const auto [id, fresh] = camera_ids.emplace(sensor, 0);
    if (fresh) {
      const auto known = sensors.find(sensor);
      if (known == sensors.end()) file.fail(camera, fmt::format("there is no sensor '{}'", sensor.substr(0, 40)));
      id->second = camera_id_of(out.model, sensor_camera(file, known->second));
    }
    const Rigid pose = transformed_world(inverse(chunk_from_camera(file, camera.child("transform"))), frame->second);
    const std::string label = camera.attribute("label").value();
    if (label.empty()) file.fail(camera, "the camera has no label: the label is the name of its photo");
    add_pose(out, pose, id->second, label, fmt::format("camera {}", camera.attribute("id").value()));
  }
  if (all.size() > aligned.size())
    out.notes.push_back(
        {"", fmt::format("{} of {} cameras of the file are not aligned", all.size() - aligned.size(), all.size())});
  return out;
}

}  // namespace vitrine
