#include "core/scene/camera/colmap_model.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/log.h"
#include "core/scene/camera/colmap_files.h"

namespace vitrine {

namespace {

constexpr ColmapCameraType kCameraTypes[] = {
    {0, "SIMPLE_PINHOLE", 3, "3.0"},
    {1, "PINHOLE", 4, "3.0"},
    {2, "SIMPLE_RADIAL", 4, "3.0"},
    {3, "RADIAL", 5, "3.0"},
    {4, "OPENCV", 8, "3.0"},
    {5, "OPENCV_FISHEYE", 8, "3.0"},
    {6, "FULL_OPENCV", 12, "3.0"},
    {7, "FOV", 5, "3.0"},
    {8, "SIMPLE_RADIAL_FISHEYE", 4, "3.0"},
    {9, "RADIAL_FISHEYE", 5, "3.0"},
    {10, "THIN_PRISM_FISHEYE", 12, "3.0"},
    {11, "RAD_TAN_THIN_PRISM_FISHEYE", 16, "3.12"},
    {12, "SIMPLE_DIVISION", 4, "4.0"},
    {13, "DIVISION", 5, "4.0"},
    {14, "SIMPLE_FISHEYE", 3, "4.0"},
    {15, "FISHEYE", 4, "4.0"},
    {16, "EUCM", 6, "4.1"},
    {17, "EQUIRECTANGULAR", 2, "4.1"},
};

// Larger sides mean a damaged file; products of two sides stay far from overflow.
constexpr uint64_t kMaxSide = uint64_t{1} << 20;

const char* const kParts[] = {"cameras", "images", "points3D"};

fs::path part_path(const fs::path& folder, const char* part, ColmapFormat format) {
  return folder / (std::string(part) + (format == ColmapFormat::Binary ? ".bin" : ".txt"));
}

bool holds_model(const fs::path& folder, ColmapFormat format) {
  std::error_code ignored;
  return fs::is_regular_file(part_path(folder, "cameras", format), ignored) &&
         fs::is_regular_file(part_path(folder, "images", format), ignored);
}

[[noreturn]] void throw_damaged(const fs::path& where, std::string why) {
  throw Error(ErrorKind::Input, "the COLMAP model cannot be used",
              {.where = where.string(),
               .why = std::move(why),
               .hint = "write the model again (colmap model_converter), or run without it to compute the poses anew",
               .code = "COLMAP_MODEL_DAMAGED"});
}

// Format in which a part exists in the folder, `preferred` if possible; nullopt: neither.
std::optional<ColmapFormat> format_of(const fs::path& folder, const char* part, ColmapFormat preferred) {
  const ColmapFormat other = preferred == ColmapFormat::Binary ? ColmapFormat::Text : ColmapFormat::Binary;
  std::error_code ignored;
  for (ColmapFormat format : {preferred, other})
    if (fs::is_regular_file(part_path(folder, part, format), ignored)) return format;
  return std::nullopt;
}

template <class T>
std::vector<T> read_part(const fs::path& path, std::vector<T> (*from_binary)(std::string_view),
                         std::vector<T> (*from_text)(std::string_view)) {
  const bool text = path.extension() == ".txt";
  const std::string bytes = text ? read_text_file(path) : read_file(path);
  try {
    return text ? from_text(bytes) : from_binary(bytes);
  } catch (const colmap::Malformed& malformed) {
    throw_damaged(path, malformed.why);
  }
}

// Gives images without poses those of their frames. Damaged rigs and frames are ignored, with a warning, if no image needs them.
void read_frames(ColmapModel& model, const fs::path& rigs, const fs::path& frames) {
  std::error_code ignored;
  if (!fs::is_regular_file(frames, ignored)) return;
  try {
    std::vector<colmap::Rig> read_rigs;
    if (fs::is_regular_file(rigs, ignored)) read_rigs = read_part(rigs, colmap::rigs_from_binary, colmap::rigs_from_text);
    const auto read = read_part(frames, colmap::frames_from_binary, colmap::frames_from_text);
    try {
      colmap::take_poses_of_frames(model.images, read_rigs, read);
    } catch (const colmap::Malformed& malformed) {
      throw_damaged(frames, malformed.why);
    }
  } catch (const Error& e) {
    if (colmap::lack_poses(model.images) || e.detail().code != "COLMAP_MODEL_DAMAGED") throw;
    log_warning("{} is not used: {}; the images have poses of their own", e.detail().where, e.detail().why);
  }
}

template <class T>
void sort_and_require_unique_ids(std::vector<T>& items, const fs::path& where, const char* what) {
  const auto by_id = [](const T& a, const T& b) { return a.id < b.id; };
  if (!std::is_sorted(items.begin(), items.end(), by_id)) std::stable_sort(items.begin(), items.end(), by_id);
  const auto twin = std::adjacent_find(items.begin(), items.end(), [](const T& a, const T& b) { return a.id == b.id; });
  if (twin != items.end()) throw_damaged(where, fmt::format("{} {} occurs twice", what, twin->id));
}

template <class T, class Id>
const T* find_by_id(const std::vector<T>& items, Id id) {
  // Ids are usually consecutive: try the direct index first.
  if (!items.empty() && id >= items.front().id && id - items.front().id < items.size()) {
    const T& guess = items[static_cast<size_t>(id - items.front().id)];
    if (guess.id == id) return &guess;
  }
  const auto it = std::lower_bound(items.begin(), items.end(), id, [](const T& item, Id wanted) { return item.id < wanted; });
  return it != items.end() && it->id == id ? &*it : nullptr;
}

bool finite(const Vec3d& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

void check_cameras(const ColmapModel& model, const fs::path& where) {
  for (const ColmapCamera& c : model.cameras) {
    const ColmapCameraType* type = colmap_camera_type(c.model_id);
    VITRINE_CHECK(type && c.params.size() == type->parameter_count, "camera {} of model {} has {} parameters", c.id, c.model_id,
                  c.params.size());
    if (c.width == 0 || c.height == 0 || c.width > kMaxSide || c.height > kMaxSide)
      throw_damaged(where, fmt::format("camera {} has the size {} x {}", c.id, c.width, c.height));
    if (!std::all_of(c.params.begin(), c.params.end(), [](double p) { return std::isfinite(p); }))
      throw_damaged(where, fmt::format("camera {} has a parameter that is not a number", c.id));
    // All models except EQUIRECTANGULAR start with a focal length.
    if (type->name != "EQUIRECTANGULAR" && !(c.params[0] > 0))
      throw_damaged(where, fmt::format("camera {} has the focal length {}", c.id, c.params[0]));
  }
}

void check_images(const ColmapModel& model, const fs::path& where, ColmapNames checked_names) {
  std::set<std::string_view> names;
  for (const ColmapImage& image : model.images) {
    const Quatd& q = image.rotation;
    const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    if (!std::isfinite(norm2) || norm2 < 1e-12 || !finite(image.translation))
      throw_damaged(where, fmt::format("the pose of image {} is not a rigid motion", image.id));
    if (!model.find_camera(image.camera_id))
      throw_damaged(where, fmt::format("image {} uses camera {}, which is not in the model", image.id, image.camera_id));
    if (checked_names == ColmapNames::Inside) {
      if (!stays_below(image.name))
        throw_damaged(
            where, fmt::format("image {} has the name '{}', which is not a path inside the image folder", image.id, image.name));
      if (!names.insert(image.name).second) throw_damaged(where, fmt::format("two images have the name '{}'", image.name));
    }
    if (model.points.empty()) continue;
    for (const ColmapPoint2D& p : image.points) {
      if (p.point3d_id != kNoPoint3D && !model.find_point(p.point3d_id))
        throw_damaged(where, fmt::format("image {} refers to point {}, which is not in the model", image.id, p.point3d_id));
    }
  }
}

void check_points(const ColmapModel& model, const fs::path& where) {
  for (const ColmapPoint3D& p : model.points) {
    if (!finite(p.position)) throw_damaged(where, fmt::format("point {} has no finite position", p.id));
    for (const ColmapTrackElement& e : p.track) {
      const ColmapImage* image = model.find_image(e.image_id);
      if (!image) throw_damaged(where, fmt::format("point {} was seen in image {}, which is not in the model", p.id, e.image_id));
      if (e.point2d_index >= image->points.size())
        throw_damaged(where, fmt::format("point {} is 2D point {} of image {}, which has only {}", p.id, e.point2d_index,
                                         e.image_id, image->points.size()));
    }
  }
}

}  // namespace

const ColmapCameraType* colmap_camera_type(int model_id) {
  for (const ColmapCameraType& type : kCameraTypes)
    if (type.id == model_id) return &type;
  return nullptr;
}

const ColmapCameraType* colmap_camera_type(std::string_view name) {
  for (const ColmapCameraType& type : kCameraTypes)
    if (type.name == name) return &type;
  return nullptr;
}

namespace colmap {

const ColmapCameraType& known_camera_type(int model_id) {
  if (const ColmapCameraType* type = colmap_camera_type(model_id)) return *type;
  throw Malformed{
      fmt::format("camera model id {} is unknown: the ids 0 to 17 of COLMAP up to 4.1 can be read; a COLMAP newer "
                  "than 4.1 and a vitrine that knows it are needed, or the file is damaged",
                  model_id)};
}

const ColmapCameraType& known_camera_type(std::string_view name) {
  if (const ColmapCameraType* type = colmap_camera_type(name)) return *type;
  if (name == "SPHERE" || name == "SPHERICAL")
    throw Malformed{
        fmt::format("camera model '{}' of a fork of COLMAP is of 360-degree panoramas: cut them into pinhole views and "
                    "give poses of these",
                    name)};
  throw Malformed{
      fmt::format("camera model '{}' is unknown: the models of COLMAP up to 4.1 can be read; a COLMAP newer than "
                  "4.1 and a vitrine that knows it are needed, or the file is damaged",
                  name.substr(0, 40))};
}

}  // namespace colmap

const ColmapCamera* ColmapModel::find_camera(uint32_t id) const { return find_by_id(cameras, id); }
const ColmapImage* ColmapModel::find_image(uint32_t id) const { return find_by_id(images, id); }
const ColmapPoint3D* ColmapModel::find_point(uint64_t id) const { return find_by_id(points, id); }

std::optional<fs::path> find_colmap_model(const fs::path& root) {
  for (const fs::path& folder : {root / "sparse" / "0", root / "sparse", root / "dense" / "sparse", root})
    if (holds_colmap_model(folder)) return folder;
  return std::nullopt;
}

bool holds_colmap_model(const fs::path& folder) {
  return format_of(folder, "cameras", ColmapFormat::Binary) && format_of(folder, "images", ColmapFormat::Binary);
}

ColmapModel read_colmap_model(const fs::path& folder) {
  ColmapModel model = read_colmap_parts(folder);
  check_colmap_model(model, folder);
  return model;
}

ColmapModel read_colmap_model(const fs::path& folder, ColmapFormat format) {
  ColmapModel model = read_colmap_parts(folder, format);
  check_colmap_model(model, folder);
  return model;
}

ColmapModel read_colmap_parts(const fs::path& folder) {
  const bool all_text = holds_model(folder, ColmapFormat::Text) && !holds_model(folder, ColmapFormat::Binary);
  return read_colmap_parts(folder, all_text ? ColmapFormat::Text : ColmapFormat::Binary);
}

ColmapModel read_colmap_parts(const fs::path& folder, ColmapFormat preferred) {
  if (!holds_colmap_model(folder))
    throw Error(ErrorKind::Input, "there is no COLMAP model here",
                {.where = folder.string(),
                 .why = "cameras and images, .bin or .txt, do not both exist",
                 .hint = "give the folder that holds them, or its parent with sparse/0",
                 .code = "COLMAP_MODEL_MISSING"});
  const auto path_of = [&](const char* part) {
    return part_path(folder, part, format_of(folder, part, preferred).value_or(preferred));
  };
  ColmapModel model;
  model.cameras = read_part(path_of("cameras"), colmap::cameras_from_binary, colmap::cameras_from_text);
  model.images = read_part(path_of("images"), colmap::images_from_binary, colmap::images_from_text);
  read_frames(model, path_of("rigs"), path_of("frames"));
  const fs::path points = path_of("points3D");
  if (fs::exists(points))
    model.points = read_part(points, colmap::points_from_binary, colmap::points_from_text);
  else
    log_warning("{} does not exist: the model is read as poses without points", points.string());
  sort_by_ids(model, folder);
  return model;
}

void write_colmap_model(const fs::path& folder, const ColmapModel& model, ColmapFormat format) {
  const bool binary = format == ColmapFormat::Binary;
  const std::string texts[] = {binary ? colmap::binary_of(model.cameras) : colmap::text_of(model.cameras),
                               binary ? colmap::binary_of(model.images) : colmap::text_of(model.images),
                               binary ? colmap::binary_of(model.points) : colmap::text_of(model.points)};
  for (size_t i = 0; i < std::size(kParts); ++i) write_file(part_path(folder, kParts[i], format), texts[i]);
}

void sort_by_ids(ColmapModel& model, const fs::path& where) {
  sort_and_require_unique_ids(model.cameras, where, "camera");
  sort_and_require_unique_ids(model.images, where, "image");
  sort_and_require_unique_ids(model.points, where, "point");
}

void check_colmap_model(ColmapModel& model, const fs::path& where, ColmapNames names) {
  sort_by_ids(model, where);
  check_cameras(model, where);
  check_images(model, where, names);
  check_points(model, where);
}

void transform_world(ColmapModel& model, const Similarity& new_from_old) {
  for (ColmapImage& image : model.images) {
    const Rigid moved = transformed_world(image.cam_from_world(), new_from_old);
    image.rotation = quaternion(moved.rotation);
    image.translation = moved.translation;
  }
  for (ColmapPoint3D& p : model.points) p.position = new_from_old * p.position;
}

}  // namespace vitrine
