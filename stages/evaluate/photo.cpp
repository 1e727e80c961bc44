#include "stages/evaluate/photo.h"

#include <algorithm>

#include "core/camera/view_set.h"
#include "core/image/exr.h"
#include "core/image/resample.h"
#include "core/math/color.h"

namespace vitrine {

ImageF photo_srgb(const std::filesystem::path& sfm_folder, const View& view, const Intrinsics& intrinsics) {
  ImageF photo = read_exr_rgb(linear_image_path(sfm_folder, view));
  if (photo.width() != intrinsics.width || photo.height() != intrinsics.height)
    photo = resized(photo, intrinsics.width, intrinsics.height);
  for (float& v : photo.data()) v = srgb_from_linear(std::clamp(v, 0.f, 1.f));
  return photo;
}

}  // namespace vitrine
