// Poses are world-from-camera with OpenGL axes (+x right, +y up, +z backward): columns 1 and 2 of the rotation change sign
// relative to ours. nerfstudio may have transformed the world: p_file = applied_scale * applied_transform(p_original).
#include "core/scene/camera/transforms_file.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/scene/camera/transforms_format.h"

namespace vitrine {

namespace {

// Looks up a key in the frame, else in the file.
class Lookup {
 public:
  Lookup(const JsonAt& top, const JsonAt& frame) : top_(top), frame_(frame) {}
  std::optional<JsonAt> find(const char* key) const {
    for (const JsonAt* j : {&frame_, &top_})
      if (j->has(key)) return j->at(key);
    return std::nullopt;
  }
  std::optional<double> number(const char* key) const {
    const auto j = find(key);
    return j ? std::optional(j->number()) : std::nullopt;
  }
  double number(const char* key, double otherwise) const { return number(key).value_or(otherwise); }

 private:
  const JsonAt& top_;
  const JsonAt& frame_;
};

// True for OPENCV_FISHEYE (nerfstudio), or is_fisheye (instant-ngp). Refuses other lenses.
bool fisheye_lens(const Lookup& in) {
  bool fisheye = false;
  if (const auto flag = in.find("is_fisheye"); flag && flag->value().is_boolean()) fisheye = flag->value().get<bool>();
  if (const auto model = in.find("camera_model")) {
    const std::string name = model->text();
    fisheye |= name == "OPENCV_FISHEYE";
    constexpr std::string_view kKnown[] = {"OPENCV_FISHEYE", "OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"};
    if (std::ranges::none_of(kKnown, [&](std::string_view known) { return name == known; }))
      model->fail("the camera model is " + name.substr(0, 40) +
                  "; supported are PINHOLE, OPENCV (k1, k2, p1, p2) and OPENCV_FISHEYE (k1 to k4): undistort the photos first");
  }
  for (const char* key : {"k3", "k4"})
    if (const auto k = in.find(key); k && !fisheye && k->number() != 0)
      k->fail("it is not zero; supported are k1, k2, p1 and p2: undistort the photos first");
  for (const char* key : {"p1", "p2"})
    if (const auto p = in.find(key); p && fisheye && p->number() != 0)
      p->fail("it is not zero; fisheye lenses have k1 to k4 here: undistort the photos first");
  return fisheye;
}

int whole_side(const JsonAt& j) {
  const double v = j.number();
  if (!(v >= 1 && v <= 1 << 20)) j.fail(fmt::format("{} is not a size in pixels", v));
  return static_cast<int>(std::lround(v));
}

StatedCamera stated_camera(const Lookup& in) {
  StatedCamera c;
  c.fisheye = fisheye_lens(in);
  const auto w = in.find("w"), h = in.find("h");
  if (w && h) c.size = {whole_side(*w), whole_side(*h)};
  const auto angle = [&](const char* key) -> std::optional<double> {
    const auto j = in.find(key);
    if (!j) return std::nullopt;
    const double v = j->number();
    if (!(v > 0 && v < M_PI)) j->fail(fmt::format("{} is not an angle in radians", v));
    return v;
  };
  const auto length = [&](const char* key) -> std::optional<double> {
    const auto j = in.find(key);
    if (!j) return std::nullopt;
    const double v = j->number();
    if (!(v > 0)) j->fail(fmt::format("the focal length {} is not positive", v));
    return v;
  };
  c.fx = length("fl_x"), c.fy = length("fl_y");
  c.angle_x = angle("camera_angle_x"), c.angle_y = angle("camera_angle_y");
  c.cx = in.number("cx"), c.cy = in.number("cy");
  c.k1 = in.number("k1", 0), c.k2 = in.number("k2", 0), c.p1 = in.number("p1", 0), c.p2 = in.number("p2", 0);
  c.k3 = in.number("k3", 0), c.k4 = in.number("k4", 0);
  return c;
}

TransformsFile transforms_of(const JsonAt& top) {
  const bool bare_list = top.value().is_array();
  if (!bare_list && !top.value().is_object()) top.fail("it is neither an object with 'frames' nor a list of frames");
  if (!bare_list && !top.has("frames"))
    top.fail(
        top.has("camera_path")
            ? "it is a camera path of nerfstudio's viewer, not the cameras of photos: give the transforms.json of the data set"
            : "'frames' is missing");
  const JsonAt frames = bare_list ? top : top.at("frames");
  frames.list("a list of frames");
  if (frames.size() == 0) top.fail("it has no frames");
  const auto applied = [&](const char* key) { return top.has(key); };
  const Similarity original_from_applied =
      applied("applied_transform") ? inverse(similarity_of(top.at("applied_transform"))) : Similarity{};
  const double applied_scale = applied("applied_scale") ? top.at("applied_scale").number() : 1.0;
  if (!(applied_scale > 0)) top.at("applied_scale").fail("the scale is not positive");
  TransformsFile file;
  if (applied("ply_file_path") && top.at("ply_file_path").value().is_string()) file.points = top.at("ply_file_path").text();
  for (size_t i = 0; i < frames.size(); ++i) {
    const JsonAt frame = frames[i];
    TransformsFrame f;
    f.place = fmt::format("frames[{}]", i);
    f.name = frame.at("file_path").text();
    file.masks += frame.has("mask_path") && frame.at("mask_path").value().is_string() && !frame.at("mask_path").text().empty();
    f.camera = stated_camera(Lookup(top, frame));
    // Exporters may leave a scale in the camera matrix; it has no meaning for a camera: only rotation and position are used.
    const char* key = bare_list && !frame.has("transform_matrix") ? "transform" : "transform_matrix";
    const Similarity file_from_cam = similarity_of(frame.at(key));
    f.cam_from_world = inverse(Rigid{original_from_applied.rotation * flipped_axes(file_from_cam.rotation),
                                     original_from_applied * (file_from_cam.translation / applied_scale)});
    file.frames.push_back(std::move(f));
  }
  return file;
}

}  // namespace

ColmapCamera StatedCamera::camera(PictureSize picture, std::optional<double> focal) const {
  if (size) picture = *size;
  VITRINE_CHECK(picture.width > 0 && picture.height > 0, "a camera without a size");
  const auto from_angle = [&](std::optional<double> angle, int side) {
    return angle ? std::optional(0.5 * side / (fisheye ? 0.5 * *angle : std::tan(0.5 * *angle))) : std::nullopt;
  };
  auto x = fx ? fx : from_angle(angle_x, picture.width), y = fy ? fy : from_angle(angle_y, picture.height);
  if (!x) x = y ? y : focal;
  if (!y) y = x;
  VITRINE_CHECK(x.has_value(), "a camera without a focal length");
  ColmapCamera out;
  out.width = static_cast<uint64_t>(picture.width);
  out.height = static_cast<uint64_t>(picture.height);
  out.params = {*x, *y, cx.value_or(0.5 * picture.width), cy.value_or(0.5 * picture.height)};
  if (fisheye) {
    out.model_id = colmap_camera_type("OPENCV_FISHEYE")->id;
    out.params.insert(out.params.end(), {k1, k2, k3, k4});
  } else if (k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0) {
    out.model_id = colmap_camera_type("OPENCV")->id;
    out.params.insert(out.params.end(), {k1, k2, p1, p2});
  }
  return out;
}

// Accepts a uniform scale times a rotation, and a translation; throws otherwise.
Similarity similarity_of(const JsonAt& rows) {
  const char* expected = "expected a 4x4 matrix: 4 (or 3) rows of 4 numbers";
  if (!rows.value().is_array() || (rows.size() != 4 && rows.size() != 3)) rows.fail(expected);
  Similarity m;
  for (size_t r = 0; r < 3; ++r) {
    const JsonAt row = rows[r];
    if (!row.value().is_array() || row.size() != 4) rows.fail(expected);
    for (size_t c = 0; c < 3; ++c) m.rotation(r, c) = row[c].number();
    m.translation[r] = row[3].number();
  }
  if (rows.size() == 4 && length(m.translation) == 0 && rows[3].value().is_array() && rows[3].size() == 4 &&
      length(Vec3d{rows[3][0].number(), rows[3][1].number(), rows[3][2].number()}) > 0)
    rows.fail("the matrix is transposed (stored by columns): its last row has the position; write it by rows");
  m.scale = std::cbrt(determinant(m.rotation));
  if (!(m.scale > 1e-9) || !std::isfinite(m.scale)) rows.fail("the matrix mirrors or flattens space");
  for (size_t c = 0; c < 3; ++c) m.rotation.column(c) = m.rotation.column(c) / m.scale;
  constexpr double kOrthogonal = 1e-3;
  const Mat3d square = transposed(m.rotation) * m.rotation;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c)
      if (std::abs(square(r, c) - (r == c)) > kOrthogonal) rows.fail("the matrix is not a rotation");
  m.rotation = rotation_matrix(quaternion(m.rotation));
  return m;
}

TransformsFile read_transforms_file(const std::filesystem::path& path) {
  TransformsFile file;
  read_json_file(path, kTransformsFormat, [&](const nlohmann::json& top) { file = transforms_of(JsonAt(top)); });
  return file;
}

}  // namespace vitrine
