// Cameras and poses of rotated photos. A file holds *stored* pixels and an EXIF orientation (1..8, core/scene/image/resample.h)
// that turns them *upright*. All stages after ingest use upright photos; poses are for the stored pixels when the program that
// computed them ignored EXIF. The conversion of pixels, camera and pose:
//
//   pixel  = S pixel_stored + offset         S: 2x2, signed permutation, the same for pixels and for camera x, y
//   camera = diag(S, 1) camera_stored        so R = diag(S, 1) R_stored, t = diag(S, 1) t_stored
//
// Orientations 2, 4, 5 and 7 also mirror: then diag(S, 1) is no rotation, and a pose exists only in a mirrored world.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/undistort.h"
#include "core/scene/camera/view_set.h"

namespace vitrine {

struct PixelSize {
  double width = 0, height = 0;
};

bool swaps_sides(int orientation);  // 5 to 8: width and height are swapped
bool is_mirrored(int orientation);  // 2, 4, 5, 7

PixelSize upright_size(const Photo& photo);  // as ingested
PixelSize stored_size(const Photo& photo);   // the same size with the sides of the file

// diag(S, 1).
Mat3d upright_from_stored(int orientation);
Vec2d upright_pixel(const Vec2d& stored, int orientation, const PixelSize& stored_size);
// Focal lengths, principal point, size and distortion of the upright picture. Throws Error{Input} for unknown lens models.
ColmapCamera upright_camera(const ColmapCamera& stored, int orientation);
// Orientations that mirror need a mirrored world too: x becomes -x.
Rigid upright_pose(const Rigid& cam_from_world, int orientation);
Vec3d mirrored_world(const Vec3d& place);

// Undistortion of the photos of an sfm artifact: maps pixels of the original photos, where users mark regions, to pixels of the
// undistorted cameras, and masks of the cameras back to the photos.
struct PhotoLenses {
  std::vector<Undistortion> undistortions;  // [view] from the ingested original photo to the undistorted one
  std::vector<std::string> photos;          // [view] name of the photo that it is cut from; that of the view if it is not cut
  std::vector<std::string> without_camera;  // photos without a pose
  bool camera_flash = false;                // the flash of the camera fired in most photos (EXIF)
  bool cut_out = false;                     // most photos have an alpha channel: outside it they may show nothing
};
// `set`: the views of the folder. Without a report an sfm artifact is assumed free of distortion. Throws Error{Input}.
PhotoLenses read_photo_lenses(const std::filesystem::path& sfm_folder, const ViewSet& set);

}  // namespace vitrine
