// transforms.json reader (nerfstudio, instant-ngp, Blender and similar). Does not match photo names or open images. Supported:
// camera-to-world matrices with OpenGL axes, 4x4 or 3x4; intrinsics global or per frame, from focal length or camera_angle_x /
// _y, with or without w and h; applied_transform and applied_scale (undone). Also the list without intrinsics written by
// `ns-export cameras`.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/view.h"

namespace vitrine {

struct PictureSize {
  int width = 0, height = 0;
  bool operator==(const PictureSize&) const = default;
};

// Intrinsics stated in the file, in pixels and radians.
struct StatedCamera {
  std::optional<PictureSize> size;
  std::optional<double> fx, fy, cx, cy, angle_x, angle_y;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  bool fisheye = false;  // OPENCV_FISHEYE: k1 to k4 are those of the angle from the axis, and p1, p2 are 0
  double k3 = 0, k4 = 0;

  bool has_focal_length() const { return fx || fy || angle_x || angle_y; }
  // PINHOLE, OPENCV or OPENCV_FISHEYE, id 0. `size` and `focal` are used if the file does not state them. Both must be known.
  ColmapCamera camera(PictureSize size, std::optional<double> focal = {}) const;
};

struct TransformsFrame {
  std::string name;   // file_path as written
  std::string place;  // "frames[3]"
  Rigid cam_from_world;
  StatedCamera camera;
};

struct TransformsFile {
  std::vector<TransformsFrame> frames;  // not empty, in file order
  std::string points;                   // ply_file_path
  size_t masks = 0;                     // frames with a mask_path
};

// Throws Error{Input} with file, line and cause: wrong format, not a rotation, unsupported lens.
TransformsFile read_transforms_file(const std::filesystem::path& path);

// Camera paths for rendering, in file order.
struct CameraPathDesc {
  std::filesystem::path file;               // transforms.json, or camera_path.json of the nerfstudio viewer
  std::optional<PictureSize> size;          // image size if the file has none
  std::function<PictureSize()> usual_size;  // same, for cameras defined by their field of view
};
// Views are named frame_0000.png and so on: names in the file may be invalid here or sort differently. Opens no image. Throws
// Error{Input}.
std::vector<View> read_camera_path(const CameraPathDesc& desc);

}  // namespace vitrine
