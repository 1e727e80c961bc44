// Files of camera poses as other programs write them, made from a model: Metashape, OpenSfM, OpenMVG. Written from the
// documentation of these programs, apart from the readers.
#pragma once

#include <cmath>
#include <string>

#include <fmt/format.h>

#include "core/scene/camera/colmap_model.h"

namespace vitrine::test {

// Parameters of PINHOLE, OPENCV or FULL_OPENCV without denominator, missing ones zero.
struct WrittenLens {
  double fx, fy, cx, cy, k1, k2, k3, p1, p2;
};
inline WrittenLens written_lens(const ColmapCamera& c) {
  const auto at = [&](size_t i) { return i < c.params.size() ? c.params[i] : 0.0; };
  return {at(0), at(1), at(2), at(3), at(4), at(5), at(8), at(6), at(7)};
}

inline std::string joined_numbers(std::initializer_list<double> numbers, const char* separator = " ") {
  std::string out;
  for (double n : numbers) out += (out.empty() ? "" : separator) + fmt::format("{:.17g}", n);
  return out;
}

struct MetashapeDesc {
  Similarity world_from_component;  // of the component or the chunk
  bool component = true;            // false: the transform is the chunk's
  std::string more_sensor, more_cameras;
};

inline std::string metashape_transform(const Similarity& s) {
  const auto& r = s.rotation;
  return fmt::format(
      "<transform><rotation locked=\"true\">{}</rotation><translation locked=\"true\">{}</translation><scale "
      "locked=\"true\">{:.17g}</scale></transform>\n",
      joined_numbers({r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)}),
      joined_numbers({s.translation.x, s.translation.y, s.translation.z}), s.scale);
}

inline std::string metashape_sensor(const ColmapCamera& c, const std::string& more = "") {
  const WrittenLens l = written_lens(c);
  return fmt::format(
      "      <sensor id=\"{}\" label=\"camera &amp; lens\" type=\"frame\">\n        <resolution width=\"{}\" height=\"{}\"/>\n"
      "        <calibration type=\"frame\" class=\"initial\"><f>1</f></calibration>\n"
      "        <calibration type=\"frame\" class=\"adjusted\">\n          <resolution width=\"{}\" height=\"{}\"/>\n          "
      "{}{}\n"
      "        </calibration>\n      </sensor>\n",
      c.id, c.width, c.height, c.width, c.height,
      fmt::format("<f>{:.17g}</f><cx>{:.17g}</cx><cy>{:.17g}</cy><b1>{:.17g}</b1><k1>{:.17g}</k1><k2>{:.17g}</k2><k3>{:.17g}</k3>"
                  "<p1>{:.17g}</p1><p2>{:.17g}</p2>",
                  l.fy, l.cx - 0.5 * double(c.width), l.cy - 0.5 * double(c.height), l.fx - l.fy, l.k1, l.k2, l.k3, l.p2, l.p1),
      more);
}

inline std::string metashape_camera(const ColmapImage& image, const Similarity& world_from_component, int component = 0) {
  const Similarity component_from_world = inverse(world_from_component);
  const Rigid p = inverse(transformed_world(image.cam_from_world(), component_from_world));  // component from camera
  const Mat3d& r = p.rotation;
  const Vec3d& t = p.translation;
  return fmt::format(
      "        <camera id=\"{}\" sensor_id=\"{}\" component_id=\"{}\" label=\"{}\">\n          <transform>{}</transform>\n"
      "          <orientation>1</orientation>\n        </camera>\n",
      image.id, image.camera_id, component, image.name,
      joined_numbers(
          {r(0, 0), r(0, 1), r(0, 2), t.x, r(1, 0), r(1, 1), r(1, 2), t.y, r(2, 0), r(2, 1), r(2, 2), t.z, 0, 0, 0, 1}));
}

inline std::string metashape_xml(const ColmapModel& model, const MetashapeDesc& desc = {}) {
  std::string sensors, cameras;
  for (const ColmapCamera& c : model.cameras) sensors += metashape_sensor(c, desc.more_sensor);
  for (const ColmapImage& image : model.images) cameras += metashape_camera(image, desc.world_from_component);
  const std::string transform = metashape_transform(desc.world_from_component);
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"2.0.0\">\n  <chunk label=\"Chunk 1\" "
         "enabled=\"true\">\n"
         "    <sensors next_id=\"9\">\n" +
         sensors + "    </sensors>\n    <components next_id=\"1\" active_id=\"0\">\n      <component id=\"0\" label=\"one\">\n" +
         (desc.component ? transform : "") +
         "      </component>\n    </components>\n    <cameras next_id=\"99\" next_group_id=\"1\">\n      <group id=\"0\" "
         "label=\"Group 1\" type=\"folder\">\n" +
         cameras + "      </group>\n        <camera id=\"98\" sensor_id=\"1\" label=\"not_aligned\"/>\n" + desc.more_cameras +
         "    </cameras>\n" + (desc.component ? "" : transform) + "  </chunk>\n</document>\n";
}

// Rotation vector: axis times angle.
inline Vec3d rotation_vector(const Mat3d& rotation) {
  Quatd q = quaternion(rotation);
  if (q.w < 0) q = {-q.w, -q.x, -q.y, -q.z};
  const Vec3d v{q.x, q.y, q.z};
  const double s = length(v);
  return s > 1e-12 ? 2 * std::atan2(s, q.w) / s * v : 2.0 * v;
}

inline std::string opensfm_json(const ColmapModel& model, const std::string& type = "brown") {
  std::string cameras, shots;
  for (const ColmapCamera& c : model.cameras) {
    const WrittenLens l = written_lens(c);
    const double size = double(std::max(c.width, c.height));
    const std::string focal = type == "perspective" ? fmt::format("\"focal\": {:.17g}", l.fx / size)
                                                    : fmt::format(
                                                          "\"focal_x\": {:.17g}, \"focal_y\": {:.17g}, \"c_x\": {:.17g}, "
                                                          "\"c_y\": {:.17g}, \"k3\": {:.17g}, \"p1\": {:.17g}, \"p2\": {:.17g}",
                                                          l.fx / size, l.fy / size, (l.cx - 0.5 * double(c.width)) / size,
                                                          (l.cy - 0.5 * double(c.height)) / size, l.k3, l.p1, l.p2);
    cameras += fmt::format(
        "{}\n    \"v2 maker {}\": {{\"projection_type\": \"{}\", \"width\": {}, \"height\": {}, {}, \"k1\": {:.17g}, "
        "\"k2\": {:.17g}}}",
        cameras.empty() ? "" : ",", c.id, type, c.width, c.height, focal, l.k1, l.k2);
  }
  for (const ColmapImage& image : model.images) {
    const Vec3d r = rotation_vector(image.cam_from_world().rotation), t = image.translation;
    shots += fmt::format(
        "{}\n    \"{}\": {{\"rotation\": [{}], \"translation\": [{}], \"camera\": \"v2 maker {}\", \"orientation\": 1}}",
        shots.empty() ? "" : ",", image.name, joined_numbers({r.x, r.y, r.z}, ", "), joined_numbers({t.x, t.y, t.z}, ", "),
        image.camera_id);
  }
  return "[\n  {\n   \"cameras\": {" + cameras + "},\n   \"shots\": {" + shots + "},\n   \"points\": {}\n  }\n]\n";
}

// `nested`: members of base classes in objects of their own, as later versions write them. Square pixels.
inline std::string openmvg_json(const ColmapModel& model, const std::string& type = "pinhole_brown_t2", bool nested = true) {
  std::string views, intrinsics, extrinsics;
  bool named = false;
  for (const ColmapCamera& c : model.cameras) {
    const WrittenLens l = written_lens(c);
    const std::string size = fmt::format("\"width\": {}, \"height\": {}", c.width, c.height);
    const std::string pinhole =
        fmt::format("\"focal_length\": {:.17g}, \"principal_point\": [{}]", l.fx, joined_numbers({l.cx, l.cy}, ", "));
    const std::string base = nested ? "\"value0\": {\"value0\": {" + size + "}, " + pinhole + "}" : size + ", " + pinhole;
    std::string lens;
    if (type == "pinhole_radial_k1") lens = fmt::format(", \"disto_k1\": [{:.17g}]", l.k1);
    if (type == "pinhole_radial_k3") lens = fmt::format(", \"disto_k3\": [{}]", joined_numbers({l.k1, l.k2, l.k3}, ", "));
    if (type == "pinhole_brown_t2")
      lens = fmt::format(", \"disto_t2\": [{}]", joined_numbers({l.k1, l.k2, l.k3, l.p1, l.p2}, ", "));
    const std::string kind =
        named ? "\"polymorphic_id\": 1" : "\"polymorphic_id\": 2147483649, \"polymorphic_name\": \"" + type + "\"";
    intrinsics += fmt::format("{}\n  {{\"key\": {}, \"value\": {{{}, \"ptr_wrapper\": {{\"id\": {}, \"data\": {{{}{}}}}}}}}}",
                              named ? "," : "", c.id, kind, 2147483700 + c.id, base, lens);
    named = true;
  }
  for (const ColmapImage& image : model.images) {
    const char* comma = views.empty() ? "" : ",";
    const Rigid pose = image.cam_from_world();
    const Mat3d& r = pose.rotation;
    const Vec3d centre = inverse(pose).translation;
    const ColmapCamera& c = *model.find_camera(image.camera_id);
    views += fmt::format(
        "{}\n  {{\"key\": {}, \"value\": {{\"polymorphic_id\": 1073741824, \"ptr_wrapper\": {{\"id\": {}, \"data\": "
        "{{\"local_path\": "
        "\"\", \"filename\": \"{}\", \"width\": {}, \"height\": {}, \"id_view\": {}, \"id_intrinsic\": {}, \"id_pose\": "
        "{}}}}}}}}}",
        comma, image.id, 2147483648 + image.id, image.name, c.width, c.height, image.id, image.camera_id, image.id);
    extrinsics +=
        fmt::format("{}\n  {{\"key\": {}, \"value\": {{\"rotation\": [[{}], [{}], [{}]], \"center\": [{}]}}}}", comma, image.id,
                    joined_numbers({r(0, 0), r(0, 1), r(0, 2)}, ", "), joined_numbers({r(1, 0), r(1, 1), r(1, 2)}, ", "),
                    joined_numbers({r(2, 0), r(2, 1), r(2, 2)}, ", "), joined_numbers({centre.x, centre.y, centre.z}, ", "));
  }
  return "{\n \"sfm_data_version\": \"0.3\",\n \"root_path\": \"/photos\",\n \"views\": [" + views + "],\n \"intrinsics\": [" +
         intrinsics + "],\n \"extrinsics\": [" + extrinsics + "],\n \"structure\": [],\n \"control_points\": []\n}\n";
}

}  // namespace vitrine::test
