// transforms.json of nerfstudio, instant-ngp, Blender and their like, as it stands: names are not matched, and no picture is
// opened. Understood: camera-to-world matrices with OpenGL axes, 4x4 or 3x4; intrinsics at the top or per frame, by focal length
// or camera_angle_x / _y, with or without w and h; applied_transform and applied_scale (undone). Also the list without intrinsics
// that `ns-export cameras` writes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

struct PictureSize {
  int width = 0, height = 0;
  bool operator==(const PictureSize&) const = default;
};

// Intrinsics as far as the file states them, in pixels and radians.
struct StatedCamera {
  std::optional<PictureSize> size;
  std::optional<double> fx, fy, cx, cy, angle_x, angle_y;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;

  bool has_focal_length() const { return fx || fy || angle_x || angle_y; }
  // PINHOLE or OPENCV, id 0. `size` is the picture's where the file states none; `focal` likewise. Both must be known.
  ColmapCamera camera(PictureSize size, std::optional<double> focal = {}) const;
};

struct TransformsFrame {
  std::string name;   // file_path as written
  std::string place;  // "frames[3]"
  Rigid cam_from_world;
  StatedCamera camera;
};

struct TransformsFile {
  std::vector<TransformsFrame> frames;  // never empty, in the order of the file
  std::string points;                   // ply_file_path
};

// Throws Error{Input} with file, line and cause: not such a file, no rotation, another lens.
TransformsFile read_transforms_file(const std::filesystem::path& path);

}  // namespace vitrine
