#include "core/render/picture/picture_views.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/scene/camera/corrected_poses.h"
#include "core/scene/camera/transforms_file.h"
#include "core/scene/camera/view_set.h"

namespace vitrine {

namespace {

std::vector<View> photo_views(const PictureViewsDesc& desc) {
  const std::vector<View> all = load_view_set(desc.sfm, desc.optimize).views;
  const std::filesystem::path list = desc.optimize / "optimize" / "views.json";
  const ViewSplit split = read_view_split(list, all);
  std::vector<size_t> chosen;
  if (desc.which != ViewChoice::Train) chosen = split.heldout;
  if (desc.which != ViewChoice::Heldout) chosen.insert(chosen.end(), split.train.begin(), split.train.end());
  std::vector<View> views = at_trained_size(all, chosen, split);
  if (views.empty())
    throw Error(ErrorKind::Input,
                fmt::format("the scene has no {} views", desc.which == ViewChoice::Train ? "training" : "held-out"),
                {.where = list.string(), .hint = "--views all", .code = "NO_VIEWS"});
  std::ranges::sort(views, {}, &View::name);
  return views;
}

std::vector<View> path_views(const PictureViewsDesc& desc) {
  CameraPathDesc path{.file = *desc.path, .size = {}, .usual_size = [&] {
                        PictureViewsDesc all = desc;
                        all.which = ViewChoice::All;
                        const Intrinsics k = photo_views(all).front().intrinsics;
                        return PictureSize{k.width, k.height};
                      }};
  if (desc.width > 0) path.size = {desc.width, desc.height};
  return read_camera_path(path);
}

}  // namespace

Intrinsics covering(const Intrinsics& k, int width, int height) {
  const double s = std::max(double(width) / k.width, double(height) / k.height);
  return {
      width, height, k.fx * s, k.fy * s, 0.5 * width + (k.cx - 0.5 * k.width) * s, 0.5 * height + (k.cy - 0.5 * k.height) * s};
}

std::vector<View> picture_views(const PictureViewsDesc& desc) {
  if (desc.which == ViewChoice::Path && !desc.path)
    throw Error(ErrorKind::Usage, "which camera path?",
                {.hint = "--input path=FILE, a transforms.json", .code = "MISSING_INPUT"});
  std::vector<View> views = desc.which == ViewChoice::Path ? path_views(desc) : photo_views(desc);
  for (View& v : views) {
    if (desc.width > 0) v.intrinsics = covering(v.intrinsics, desc.width, desc.height);
    if (v.intrinsics.longest_side() > kMaxPictureSide)
      throw Error(ErrorKind::Input,
                  fmt::format("a picture of {}x{} pixels is too large", v.intrinsics.width, v.intrinsics.height),
                  {.where = v.name, .hint = "give a smaller size: width, height", .code = "PICTURE_TOO_LARGE"});
  }
  return views;
}

}  // namespace vitrine
