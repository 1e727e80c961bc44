#include "stages/mark/mark.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/json_file.h"
#include "core/intake/poses/photo_orientation.h"
#include "core/scene/camera/view_masks.h"

namespace vitrine {

namespace {

constexpr int kMaskSide = 800;  // longest side of the masks in the page: outlines are within a pixel of a photo on a screen

// Resamples a mask of the undistorted photo to the original photo; pixels cropped by the undistortion are outside.
MaskRuns runs_of(const ImageF& mask, const Undistortion& u, int width, int height) {
  MaskRuns runs;
  bool inside = false;
  int length = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Vec2d taken{(x + 0.5) / width * double(u.source.width), (y + 0.5) / height * double(u.source.height)};
      const std::optional<Vec2d> at = undistorted(taken, u);
      const int i = at ? int(std::floor(at->x)) : -1, j = at ? int(std::floor(at->y)) : -1;
      const bool now = i >= 0 && j >= 0 && i < mask.width() && j < mask.height() && mask.at(i, j) >= 0.5f;
      if (now != inside) runs.push_back(std::exchange(length, 0)), inside = now;
      ++length;
    }
  runs.push_back(length);
  return runs;
}

}  // namespace

RunResults read_run_results(const fs::path& sfm, const std::optional<fs::path>& masks) {
  RunResults results;
  const ViewSet set = load_view_set(sfm);
  const PhotoLenses lenses = read_photo_lenses(sfm, set);
  std::vector<RunPhoto> photos(set.views.size());
  parallel_for(photos.size(), 1, [&](size_t v) {
    throw_if_interrupted();
    const Undistortion& u = lenses.undistortions[v];
    RunPhoto& photo = photos[v];
    photo = {.view = set.views[v], .width = double(u.source.width), .height = double(u.source.height), .masks = {}};
    const double s = std::min(1.0, kMaskSide / std::max(photo.width, photo.height));
    photo.mask_width = std::max(int(std::lround(s * photo.width)), 1);
    photo.mask_height = std::max(int(std::lround(s * photo.height)), 1);
    for (MaskClass kind : kMaskClasses)
      if (const auto mask = masks ? read_view_mask(*masks, kind, photo.view) : std::nullopt)
        photo.masks[size_t(kind)] = runs_of(*mask, u, photo.mask_width, photo.mask_height);
  });
  for (size_t v = 0; v < photos.size(); ++v) results.photos.emplace(set.views[v].name, std::move(photos[v]));
  if (!masks) return results;
  for (const MaskClass kind : kMaskClasses)
    if (fs::is_directory(*masks / "masks" / name(kind)))
      results.sources[std::string(name(kind))] = mask_origin(*masks, kind).source;
  return results;
}

}  // namespace vitrine
