#include "stages/normals/capture.h"

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/image/exr.h"
#include "core/image/ldr.h"
#include "core/image/resample.h"

namespace vitrine {

ImageF NormalCapture::photo(size_t view, int width, int height) const {
  const View& v = set.views[view];
  const fs::path path = linear_image_path(sfm, v);
  const ImageF linear = read_exr_rgb(path);
  if (linear.width() != v.intrinsics.width || linear.height() != v.intrinsics.height)
    throw Error(ErrorKind::Input, "a photo and its camera have different sizes",
                {.where = path.string(),
                 .why = fmt::format("the file has {} x {} pixels, the camera model {} x {}", linear.width(), linear.height(),
                                    v.intrinsics.width, v.intrinsics.height),
                 .hint = "run the sfm stage again",
                 .code = "SIZE_MISMATCH"});
  return srgb_from_linear_image(resized(linear, width, height));
}

NormalCapture load_normal_capture(const std::filesystem::path& sfm, const std::optional<std::filesystem::path>& objects,
                                  int holdout_every) {
  NormalCapture capture{.sfm = sfm, .objects = LabelledObjects::trusted(objects), .set = load_view_set(sfm), .helpers = {}};
  for (uint32_t v = 0; v < capture.set.views.size(); ++v)
    if (!is_heldout(v, holdout_every)) capture.helpers.push_back(v);
  return capture;
}

}  // namespace vitrine
