// Determines the pixel convention of given poses: stored or upright pixels (EXIF orientation, photo_orientation.h), the picture
// size, and whether they are for the photo at all (an undistorted picture is another picture). All other code uses this result.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/intake/poses/photo_orientation.h"

namespace vitrine {

enum class PoseSource { Colmap, Transforms, Matrices, Metashape, OpenSfm, OpenMvg };
std::string_view name(PoseSource source);  // "COLMAP model", "transforms.json", "projection matrices", ..

// Decision for one photo.
struct PosedPhoto {
  std::string name;
  int orientation = 1;   // EXIF, of the photo
  PixelSize given = {};  // size of the pose's camera
  PixelSize stored = {}, upright = {};
  bool fits_stored = false, fits_upright = false;  // same aspect ratio
  bool for_stored = false;  // the pose is for the stored pixels: camera and pose are rotated with the photo
  bool settled = true;      // by sizes and orientations; else an assumption that the photos may overrule (pose_check.h)
  bool left_out = false;    // the pose is for a mirrored picture in a world that is not mirrored
};

struct PosePixels {
  PoseSource source = PoseSource::Colmap;
  std::vector<PosedPhoto> photos;  // photos with a pose
  bool oddly_resized = false;      // another size by an unusual ratio: resized is assumed, cropped is possible
  Notes notes;

  bool open() const;  // some photo is not settled
};

// `width`, `height`: of the pose's camera. If neither orientation fits, the photos are cropped or rotated.
PosedPhoto posed_photo(const Photo& photo, double width, double height);
// The camera has the size of the upright photo, but its principal point is in the middle of the stored one: width and height
// come from the photo or from another tool, the other parameters are for the stored pixels.
bool sides_look_swapped(const Photo& photo, const ColmapCamera& camera);
// Fills for_stored, settled and left_out jointly: one program computed all poses and either applied EXIF or ignored it. Photos
// whose shape fits only one orientation decide for those that fit both (half turns, mirrored and square photos).
void settle_pixels(PosePixels& pixels);

// Adds notes on sizes; throws Error{Input}, POSES_UNDISTORTED for poses of undistorted pictures. `cameras`: as given, one for
// every photo of `pixels`. `model`: folder or file of the poses; pictures of the cameras' size are searched in and next to it.
void check_pixel_sizes(PosePixels& pixels, std::span<const Photo* const> photos, std::span<const ColmapCamera> cameras,
                       const std::filesystem::path& model);
// Path of the pictures that the poses belong to, for the message about cameras of another shape; empty when not found.
std::filesystem::path pictures_beside(const std::filesystem::path& model, const std::vector<std::string>& names,
                                      const PixelSize& size);

// Converts a given camera to that of the upright photo at the size of `photo`.
ColmapCamera camera_on_photo(const ColmapCamera& given, const PosedPhoto& photo);
Vec2d point_on_photo(const Vec2d& given, const PosedPhoto& photo);

}  // namespace vitrine
