#include "core/scene/camera/transforms_file.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/scene/camera/transforms_format.h"

namespace vitrine {

namespace {

constexpr const char* kPathFormat = "camera path";

// nerfstudio viewer format: "camera_path": [{"camera_to_world": [16 numbers, row-major], "fov": vertical, degrees}], and
// render_width, render_height. Axes as in transforms.json.
std::vector<TransformsFrame> viewer_frames(const JsonAt& top) {
  if (top.has("camera_type"))
    if (const std::string type = top.at("camera_type").text(); type != "perspective")
      top.at("camera_type").fail("its cameras are '" + type.substr(0, 40) + "'; perspective ones can be rendered");
  std::optional<PictureSize> size;
  const auto side = [&](const char* key) {
    const double v = top.at(key).number();
    if (!(v >= 1 && v <= 1 << 20)) top.at(key).fail(fmt::format("{} is not a size in pixels", v));
    return int(std::lround(v));
  };
  if (top.has("render_width") && top.has("render_height")) size = {side("render_width"), side("render_height")};
  const JsonAt cameras = top.at("camera_path");
  if (cameras.list("a list of cameras").size() == 0) cameras.fail("it has no cameras");
  std::vector<TransformsFrame> frames;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const JsonAt camera = cameras[i], matrix = camera.at("camera_to_world");
    nlohmann::json rows = matrix.value();
    if (rows.is_array() && (rows.size() == 16 || rows.size() == 12)) {
      rows = nlohmann::json::array();
      for (size_t r = 0; r < matrix.size() / 4; ++r)
        rows.push_back(
            {matrix[4 * r].number(), matrix[4 * r + 1].number(), matrix[4 * r + 2].number(), matrix[4 * r + 3].number()});
    }
    Similarity world_from_cam;
    try {
      world_from_cam = similarity_of(JsonAt(rows));
    } catch (const JsonMistake& e) {
      matrix.fail(e.what());
    }
    const double fov_deg = camera.at("fov").number();
    if (!(fov_deg > 0 && fov_deg < 180)) camera.at("fov").fail(fmt::format("{} is not an angle of view in degrees", fov_deg));
    TransformsFrame frame{.name = {}, .place = fmt::format("camera_path[{}]", i), .cam_from_world = {}, .camera = {}};
    frame.cam_from_world = inverse(Rigid{flipped_axes(world_from_cam.rotation), world_from_cam.translation});
    frame.camera.size = size;
    frame.camera.angle_y = fov_deg * M_PI / 180;
    frames.push_back(std::move(frame));
  }
  return frames;
}

std::vector<TransformsFrame> frames_of(const std::filesystem::path& path) {
  std::vector<TransformsFrame> frames;
  read_json_file(path, kPathFormat, [&](const nlohmann::json& j) {
    if (const JsonAt top(j); top.has("camera_path")) frames = viewer_frames(top);
  });
  return frames.empty() ? read_transforms_file(path).frames : frames;
}

}  // namespace

std::vector<View> read_camera_path(const CameraPathDesc& desc) {
  const std::vector<TransformsFrame> frames = frames_of(desc.file);
  const size_t digits = std::max<size_t>(4, std::to_string(frames.size() - 1).size());
  std::vector<View> views;
  for (const TransformsFrame& frame : frames) {
    const StatedCamera& stated = frame.camera;
    const auto refuse = [&](const std::string& why) { throw_bad_json(desc.file, kPathFormat, frame.place + ": " + why); };
    if (!stated.has_focal_length()) refuse("neither fl_x nor camera_angle_x is given, here or at the top");
    std::optional<PictureSize> size = stated.size ? stated.size : desc.size;
    // A focal length in pixels requires the image size; a field of view applies to every size.
    if (!size && !stated.fx && !stated.fy && !stated.cx && !stated.cy && desc.usual_size) size = desc.usual_size();
    if (!size)
      refuse("w and h are missing: without the size of the picture, fl_x in pixels means nothing; add them, or give --size");
    const ColmapCamera camera = stated.camera(*size);
    if (is_distorted(camera)) refuse("it has lens distortion, and pictures are rendered without");
    views.push_back(
        {fmt::format("frame_{:0{}}.png", views.size(), digits), pinhole_part(camera), frame.cam_from_world, {1, 1, 1}});
  }
  return views;
}

}  // namespace vitrine
