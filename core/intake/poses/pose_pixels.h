// For which pixels given poses are: the photo's stored ones or its upright ones (EXIF orientation, photo_orientation.h), at which
// size, and whether they are those of the photo at all (an undistorted picture is another picture). The one place that decides
// it.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/foundation/base/note.h"
#include "core/intake/poses/photo_orientation.h"

namespace vitrine {

enum class PoseSource { Colmap, Transforms, Matrices };
std::string_view name(PoseSource source);  // "COLMAP model", "transforms.json", "projection matrices"

// What was decided about one photo.
struct PosedPhoto {
  std::string name;
  int orientation = 1;   // EXIF, of the photo
  PixelSize given = {};  // size of the pose's camera
  PixelSize stored = {}, upright = {};
  bool fits_stored = false, fits_upright = false;  // in shape
  bool for_stored = false;                         // the pose is for the stored pixels: camera and pose are turned with the photo
  bool settled = true;    // by sizes and orientations; else it is an assumption that the photos may overrule (pose_check.h)
  bool left_out = false;  // the pose is of a mirrored picture in a world that is not mirrored
};

struct PosePixels {
  PoseSource source = PoseSource::Colmap;
  std::vector<PosedPhoto> photos;  // with a pose
  bool oddly_resized = false;      // another size, and no usual ratio: resized is an assumption, cropped is possible
  Notes notes;

  bool open() const;  // some photo is not settled
};

// `width`, `height`: of the pose's camera. Neither fits: the photos are cropped or turned.
PosedPhoto posed_photo(const Photo& photo, double width, double height);
// The camera has the sides of the upright photo, but its principal point is in the middle of the stored one: width and height are
// taken from the photo or from another tool, the rest is for the stored pixels.
bool sides_look_swapped(const Photo& photo, const ColmapCamera& camera);
// Fills for_stored, settled and left_out, jointly: one program made all the poses, and either heeded EXIF or did not. Photos
// whose shape fits only one way decide for those that fit both ways (half turns, mirrored and square photos).
void settle_pixels(PosePixels& pixels);

// Notes on sizes, and the refusal of poses of undistorted pictures (Error{Input}, POSES_UNDISTORTED). `cameras`: as given, one
// for every photo of `pixels`. `model`: the folder or file of the poses; pictures of the cameras' size are looked for in and
// beside it.
void check_pixel_sizes(PosePixels& pixels, std::span<const Photo* const> photos, std::span<const ColmapCamera> cameras,
                       const std::filesystem::path& model);
// For the message about cameras of another shape: where the pictures are that the poses belong to; empty when not found.
std::filesystem::path pictures_beside(const std::filesystem::path& model, const std::vector<std::string>& names,
                                      const PixelSize& size);

// The camera of the upright photo at the size of `photo`, from a camera as given.
ColmapCamera camera_on_photo(const ColmapCamera& given, const PosedPhoto& photo);
Vec2d point_on_photo(const Vec2d& given, const PosedPhoto& photo);

}  // namespace vitrine
