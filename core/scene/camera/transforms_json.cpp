// Reader and writer of transforms.json for undistorted views.
#include <algorithm>
#include <set>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/folder_files.h"
#include "core/scene/camera/transforms_file.h"
#include "core/scene/camera/transforms_format.h"
#include "core/scene/camera/view_set.h"

namespace vitrine {

namespace {

using nlohmann::json;

// Common prefix to remove from all names: up to "images" if all frames are below such a folder, else the deepest shared folder.
fs::path shared_folder(const std::vector<fs::path>& paths) {
  const std::vector<fs::path> first(paths.front().begin(), paths.front().end());
  size_t shared = first.empty() ? 0 : first.size() - 1;
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

json intrinsics_json(const Intrinsics& k) {
  return {{"w", k.width}, {"h", k.height}, {"fl_x", k.fx}, {"fl_y", k.fy}, {"cx", k.cx}, {"cy", k.cy}};
}

}  // namespace

std::vector<View> read_transforms_json(const fs::path& path, const SizeOfView& size_of) {
  const TransformsFile file = read_transforms_file(path);
  std::vector<fs::path> paths;
  for (const TransformsFrame& frame : file.frames) paths.push_back(fs::path(frame.name).lexically_normal());
  const fs::path shared = shared_folder(paths);
  std::vector<View> views;
  std::set<std::string> names;
  for (size_t i = 0; i < paths.size(); ++i) {
    const TransformsFrame& frame = file.frames[i];
    const std::string name = (shared.empty() ? paths[i] : paths[i].lexically_relative(shared)).generic_string();
    const auto refuse = [&](const std::string& why) { throw_bad_json(path, kTransformsFormat, frame.place + ": " + why); };
    if (!stays_below(name)) refuse("'" + name + "' is not a path inside a folder");
    if (!names.insert(name).second) refuse("a frame before it has the name '" + name + "', too");
    if (!frame.camera.has_focal_length()) refuse("neither fl_x nor camera_angle_x is given, here or at the top");
    std::optional<PictureSize> size = frame.camera.size;
    if (!size && size_of) size = size_of(name);
    if (!size) refuse("w and h are missing, here and at the top");
    const ColmapCamera camera = frame.camera.camera(*size);
    if (is_distorted(camera)) refuse("'" + name + "' has lens distortion, where undistorted views are needed");
    views.push_back({name, pinhole_part(camera), frame.cam_from_world, {1, 1, 1}});
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
