// transforms.json. Its poses are world-from-camera with OpenGL axes (+x right, +y up, +z backward): columns 1 and 2 of the
// rotation change sign against ours. nerfstudio may have moved the world: p_file = applied_scale * applied_transform(p_original).
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/camera/json_file.h"
#include "core/camera/view_set.h"
#include "core/image/exr.h"
#include "core/image/ldr.h"

namespace vitrine {

namespace {

using nlohmann::json;

constexpr const char* kTransformsFormat = "transforms.json";
const char* const kImageExtensions[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr", ".PNG", ".JPG", ".JPEG"};

// A key of the frame, else of the file.
class Lookup {
 public:
  Lookup(const json& top, const json& frame) : top_(top), frame_(frame) {}
  const json* find(const char* key) const {
    for (const json* j : {&frame_, &top_})
      if (const auto it = j->find(key); it != j->end() && !it->is_null()) return &*it;
    return nullptr;
  }
  std::optional<double> number(const char* key) const {
    const json* j = find(key);
    if (!j) return std::nullopt;
    const double v = j->get<double>();
    if (!std::isfinite(v)) throw std::invalid_argument(std::string(key) + " is not finite");
    return v;
  }
  double number(const char* key, double otherwise) const { return number(key).value_or(otherwise); }

 private:
  const json& top_;
  const json& frame_;
};

struct Size {
  int width = 0, height = 0;
};

Size size_of_photo(const fs::path& path) {
  if (path.extension() == ".exr") {
    const ExrImage image = read_exr(path);
    return {image.pixels.width(), image.pixels.height()};
  }
  const ImageF image = read_unchanged(path);
  return {image.width(), image.height()};
}

int whole_side(double v, const char* key) {
  if (!(v >= 1 && v <= 1 << 20)) throw std::invalid_argument(fmt::format("{} = {} is not a size in pixels", key, v));
  return static_cast<int>(std::lround(v));
}

void refuse_other_lenses(const Lookup& in) {
  const json* model = in.find("camera_model");
  const std::string name = model ? model->get<std::string>() : "OPENCV";
  const json* fisheye = in.find("is_fisheye");
  if ((name != "OPENCV" && name != "PINHOLE" && name != "SIMPLE_PINHOLE" && name != "SIMPLE_RADIAL" && name != "RADIAL") ||
      (fisheye && fisheye->is_boolean() && fisheye->get<bool>()))
    throw std::invalid_argument("its camera model is " + (fisheye ? std::string("fisheye") : name) +
                                "; supported are PINHOLE and OPENCV (k1, k2, p1, p2): undistort the photos first");
  if (in.number("k3", 0) != 0 || in.number("k4", 0) != 0)
    throw std::invalid_argument("k3 or k4 is not zero; supported are k1, k2, p1 and p2: undistort the photos first");
}

ColmapCamera camera_of(const Lookup& in, const std::function<Size()>& photo_size) {
  refuse_other_lenses(in);
  const auto w = in.number("w"), h = in.number("h");
  const Size size = w && h ? Size{whole_side(*w, "w"), whole_side(*h, "h")} : photo_size();
  const auto from_angle = [&](const char* key, int side) -> std::optional<double> {
    const auto angle = in.number(key);
    if (!angle) return std::nullopt;
    if (!(*angle > 0 && *angle < M_PI))
      throw std::invalid_argument(fmt::format("{} = {} is not an angle in radians", key, *angle));
    return 0.5 * side / std::tan(0.5 * *angle);
  };
  auto fx = in.number("fl_x"), fy = in.number("fl_y");
  if (!fx) fx = from_angle("camera_angle_x", size.width);
  if (!fy) fy = from_angle("camera_angle_y", size.height);
  if (!fx) fx = fy;
  if (!fy) fy = fx;
  if (!fx) throw std::invalid_argument("neither fl_x nor camera_angle_x is given, at the top or in the frame");
  if (!(*fx > 0 && *fy > 0)) throw std::invalid_argument("the focal length is not positive");
  ColmapCamera camera;
  camera.width = static_cast<uint64_t>(size.width);
  camera.height = static_cast<uint64_t>(size.height);
  camera.params = {*fx, *fy, in.number("cx", 0.5 * size.width), in.number("cy", 0.5 * size.height)};
  const double distortion[] = {in.number("k1", 0), in.number("k2", 0), in.number("p1", 0), in.number("p2", 0)};
  if (std::any_of(std::begin(distortion), std::end(distortion), [](double d) { return d != 0; })) {
    camera.model_id = colmap_camera_type("OPENCV")->id;
    camera.params.insert(camera.params.end(), std::begin(distortion), std::end(distortion));
  }
  return camera;
}

// The upper three rows of a 4x4 (or 3x4) matrix: a uniform scale times a rotation, and a translation. Anything else is refused.
Similarity similarity_of(const json& rows, const char* what) {
  if (!rows.is_array() || (rows.size() != 4 && rows.size() != 3))
    throw std::invalid_argument(std::string(what) + " is not a 4x4 matrix");
  Similarity m;
  for (size_t r = 0; r < 3; ++r) {
    if (!rows[r].is_array() || rows[r].size() != 4) throw std::invalid_argument(std::string(what) + " is not a 4x4 matrix");
    for (size_t c = 0; c < 3; ++c) m.rotation(r, c) = rows[r][c].get<double>();
    m.translation[r] = rows[r][3].get<double>();
    if (!std::isfinite(m.translation[r])) throw std::invalid_argument(std::string(what) + " is not finite");
  }
  m.scale = std::cbrt(determinant(m.rotation));
  if (!(m.scale > 1e-9) || !std::isfinite(m.scale)) throw std::invalid_argument(std::string(what) + " mirrors or flattens space");
  for (size_t c = 0; c < 3; ++c) m.rotation.column(c) = m.rotation.column(c) / m.scale;
  constexpr double kOrthogonal = 1e-3;
  const Mat3d square = transposed(m.rotation) * m.rotation;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c)
      if (std::abs(square(r, c) - (r == c)) > kOrthogonal) throw std::invalid_argument(std::string(what) + " is not a rotation");
  m.rotation = rotation_matrix(quaternion(m.rotation));
  return m;
}

Mat3d flipped_axes(Mat3d rotation) {  // OpenGL camera axes <-> ours
  rotation.c1 = -rotation.c1;
  rotation.c2 = -rotation.c2;
  return rotation;
}

// The photo of a frame; when file_path has no extension, the first file that exists with one.
fs::path photo_path(const fs::path& folder, const fs::path& file_path) {
  std::error_code ignored;
  const auto known = [](const fs::path& extension) {
    return std::find(std::begin(kImageExtensions), std::end(kImageExtensions), extension) != std::end(kImageExtensions);
  };
  if (known(file_path.extension()) || fs::is_regular_file(folder / file_path, ignored)) return file_path;
  for (const char* extension : kImageExtensions) {
    const fs::path with = fs::path(file_path) += extension;
    if (fs::is_regular_file(folder / with, ignored)) return with;
  }
  return file_path;
}

// The folder to take off every name: up to "images" when all frames lie below such a folder, else all that they share.
fs::path shared_folder(const std::vector<fs::path>& paths) {
  const std::vector<fs::path> first(paths.front().begin(), paths.front().end());
  size_t shared = first.size() - 1;
  for (const fs::path& path : paths) {
    const std::vector<fs::path> parts(path.begin(), path.end());
    size_t same = 0;
    while (same < shared && same + 1 < parts.size() && parts[same] == first[same]) ++same;
    shared = same;
  }
  const auto images = std::find(first.begin(), first.begin() + static_cast<long>(shared), fs::path("images"));
  if (images != first.begin() + static_cast<long>(shared)) shared = static_cast<size_t>(images - first.begin()) + 1;
  fs::path folder;
  for (size_t i = 0; i < shared; ++i) folder /= first[i];
  return folder;
}

ColmapModel model_of(const json& top, const fs::path& folder) {
  const json& frames = top.at("frames");
  if (!frames.is_array() || frames.empty()) throw std::invalid_argument("it has no frames");
  const Similarity original_from_applied =
      top.contains("applied_transform") ? inverse(similarity_of(top["applied_transform"], "applied_transform")) : Similarity{};
  const double applied_scale = top.value("applied_scale", 1.0);
  if (!(applied_scale > 0)) throw std::invalid_argument("applied_scale is not positive");
  std::vector<fs::path> paths;
  for (const json& frame : frames)
    paths.push_back(photo_path(folder, fs::path(frame.at("file_path").get<std::string>()).lexically_normal()));
  const fs::path shared = shared_folder(paths);
  Size first_photo;  // photos without w and h share one size: opened once
  ColmapModel model;
  for (size_t i = 0; i < paths.size(); ++i) {
    ColmapCamera camera = camera_of(Lookup(top, frames[i]), [&] {
      if (first_photo.width == 0) first_photo = size_of_photo(path_inside(folder, paths[i]));
      return first_photo;
    });
    const auto same =
        std::find_if(model.cameras.begin(), model.cameras.end(), [&](ColmapCamera c) { return c.id = 0, c == camera; });
    camera.id = static_cast<uint32_t>(same - model.cameras.begin()) + 1;
    if (same == model.cameras.end()) model.cameras.push_back(camera);
    // A scale that an exporter left in the camera's matrix has no meaning for a camera: only rotation and place are used.
    const Similarity file_from_cam = similarity_of(frames[i].at("transform_matrix"), "transform_matrix");
    const Rigid world_from_cam{original_from_applied.rotation * flipped_axes(file_from_cam.rotation),
                               original_from_applied * (file_from_cam.translation / applied_scale)};
    const Rigid cam_from_world = inverse(world_from_cam);
    ColmapImage image;
    image.id = static_cast<uint32_t>(i) + 1;
    image.rotation = quaternion(cam_from_world.rotation);
    image.translation = cam_from_world.translation;
    image.camera_id = camera.id;
    image.name = (shared.empty() ? paths[i] : paths[i].lexically_relative(shared)).generic_string();
    model.images.push_back(std::move(image));
  }
  return model;
}

json intrinsics_json(const Intrinsics& k) {
  return {{"w", k.width}, {"h", k.height}, {"fl_x", k.fx}, {"fl_y", k.fy}, {"cx", k.cx}, {"cy", k.cy}};
}

}  // namespace

ColmapModel read_transforms_model(const fs::path& path) {
  ColmapModel model;
  read_json_file(path, kTransformsFormat, [&](const json& top) { model = model_of(top, path.parent_path()); });
  check_colmap_model(model, path);
  return model;
}

std::vector<View> read_transforms_json(const fs::path& path) {
  const ColmapModel model = read_transforms_model(path);
  std::vector<View> views;
  for (const ColmapImage& image : model.images) {
    const ColmapCamera& camera = *model.find_camera(image.camera_id);
    if (is_distorted(camera))
      throw_bad_json(path, kTransformsFormat, "'" + image.name + "' has lens distortion, where undistorted views are needed");
    views.push_back({image.name, pinhole_part(camera), image.cam_from_world(), {1, 1, 1}});
  }
  std::sort(views.begin(), views.end(), [](const View& a, const View& b) { return a.name < b.name; });
  return views;
}

void write_transforms_json(const fs::path& path, const std::vector<View>& views, const std::string& image_folder) {
  json top = {{"camera_model", "PINHOLE"}, {"frames", json::array()}};
  const bool one_camera =
      std::all_of(views.begin(), views.end(), [&](const View& v) { return v.intrinsics == views[0].intrinsics; });
  if (one_camera && !views.empty()) top.update(intrinsics_json(views[0].intrinsics));
  for (const View& view : views) {
    const Rigid world_from_cam = inverse(view.cam_from_world);
    const Mat3d rows = transposed(flipped_axes(world_from_cam.rotation));
    json matrix = json::array();
    for (size_t r = 0; r < 3; ++r) {
      const Vec3d& row = rows.column(r);
      matrix.push_back({row.x, row.y, row.z, world_from_cam.translation[r]});
    }
    matrix.push_back({0.0, 0.0, 0.0, 1.0});
    json frame = {{"file_path", (fs::path(image_folder) / view.name).generic_string()}, {"transform_matrix", matrix}};
    if (!one_camera) frame.update(intrinsics_json(view.intrinsics));
    top["frames"].push_back(std::move(frame));
  }
  write_json_file(path, top);
}

}  // namespace vitrine
