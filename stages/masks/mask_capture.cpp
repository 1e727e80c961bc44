#include "core/camera/photo_lenses.h"
#include "stages/masks/mask_source.h"

namespace vitrine {

MaskCapture read_mask_capture(const std::filesystem::path& sfm_folder) {
  MaskCapture capture{.sfm_folder = sfm_folder, .set = load_view_set(sfm_folder), .undistortions = {}};
  PhotoLenses lenses = read_photo_lenses(sfm_folder, capture.set);
  capture.undistortions = std::move(lenses.undistortions);
  capture.without_camera = std::move(lenses.without_camera);
  return capture;
}

}  // namespace vitrine
