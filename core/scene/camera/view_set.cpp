#include "core/scene/camera/view_set.h"

#include <algorithm>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/math/color.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"

namespace vitrine {

namespace fs = std::filesystem;

namespace {

std::vector<ScenePoint> scene_points(const ColmapModel& model, const std::vector<View>& views) {
  std::vector<uint32_t> index_of_image(model.images.size());  // index in model.images -> index in views
  for (size_t i = 0; i < model.images.size(); ++i) {
    const auto at = std::lower_bound(views.begin(), views.end(), model.images[i].name,
                                     [](const View& v, const std::string& name) { return v.name < name; });
    index_of_image[i] = static_cast<uint32_t>(at - views.begin());
  }
  std::vector<ScenePoint> points;
  points.reserve(model.points.size());
  for (const ColmapPoint3D& p : model.points) {
    ScenePoint point;
    point.position = p.position;
    for (size_t c = 0; c < 3; ++c) point.linear_rgb[c] = linear_from_srgb(static_cast<float>(p.srgb[c]) / 255.0f);
    point.error_px = p.error_px;
    for (const ColmapTrackElement& e : p.track)
      point.views.push_back(index_of_image[static_cast<size_t>(model.find_image(e.image_id) - model.images.data())]);
    std::sort(point.views.begin(), point.views.end());
    point.views.erase(std::unique(point.views.begin(), point.views.end()), point.views.end());
    points.push_back(std::move(point));
  }
  return points;
}

}  // namespace

ViewSet load_view_set(const fs::path& sfm_folder) {
  const fs::path folder = sfm_folder / "sparse" / "0";
  const ColmapModel model = read_colmap_model(folder);
  const fs::path gains_path = sfm_folder / "sfm" / "gains.json";
  const Gains gains = read_gains(gains_path);
  ViewSet set;
  set.scene_from_colmap = read_scene_info(sfm_folder / "scene.json").scene_from_colmap;
  for (const ColmapImage& image : model.images) {
    const ColmapCamera& camera = *model.find_camera(image.camera_id);
    if (is_distorted(camera))
      throw Error(
          ErrorKind::Input, "the photos of this model are not undistorted",
          {.where = folder.string(),
           .why = fmt::format("image '{}' has lens distortion ({})", image.name, colmap_camera_type(camera.model_id)->name),
           .hint = "run the sfm stage on it with --poses",
           .code = "NOT_UNDISTORTED"});
    const auto gain = gains.find(image.name);
    if (gain == gains.end())
      throw Error(ErrorKind::Input, "a view has no gain",
                  {.where = gains_path.string(),
                   .why = fmt::format("'{}' is in sparse/0 but not in this file", image.name),
                   .hint = "run the sfm stage again",
                   .code = "GAIN_MISSING"});
    set.views.push_back({image.name, pinhole_part(camera), image.cam_from_world(), gain->second});
  }
  std::sort(set.views.begin(), set.views.end(), [](const View& a, const View& b) { return a.name < b.name; });
  set.points = scene_points(model, set.views);
  return set;
}

fs::path linear_image_path(const fs::path& sfm_folder, const View& view) {
  return sfm_folder / "linear" / (view.stem() + ".exr");
}

ViewSplit read_view_split(const std::filesystem::path& path, const std::vector<View>& views) {
  const auto fail = [&](const std::string& why) -> Error {
    return Error(ErrorKind::Input, "the list of training and held-out views is unusable",
                 {.where = path.string(), .why = why, .hint = "run the optimize stage again", .code = "BAD_VIEW_SPLIT"});
  };
  std::map<std::string, size_t> index;
  for (size_t i = 0; i < views.size(); ++i) index.emplace(views[i].name, i);
  const std::string text = read_file(path);
  ViewSplit split;
  try {
    const auto json = nlohmann::json::parse(text);
    split.holdout_every = json.at("holdout_every").get<int>();
    split.max_side = json.at("max_side").get<int>();
    split.object_alone = json.value("object_alone", false);
    for (const auto& [key, list] : {std::pair{"train", &split.train}, {"heldout", &split.heldout}})
      for (const auto& item : json.at(key)) {
        const auto it = index.find(item.get<std::string>());
        if (it == index.end()) throw fail("no view is called " + item.get<std::string>());
        list->push_back(it->second);
      }
  } catch (const nlohmann::json::exception& e) {
    throw fail(cause_of(e));
  }
  if (split.max_side < 0) throw fail("max_side is negative");
  if (split.train.empty() && split.heldout.empty()) throw fail("it names no views");
  return split;
}

std::vector<View> at_trained_size(const std::vector<View>& views, const std::vector<size_t>& indices, const ViewSplit& split) {
  std::vector<View> out;
  for (size_t i : indices) {
    out.push_back(views[i]);
    out.back().intrinsics = out.back().intrinsics.limited_to(split.max_side);
  }
  return out;
}

}  // namespace vitrine
