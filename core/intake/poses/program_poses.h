// Readers of the camera poses of other programs. Each gives cameras in pixels (origin at the upper left corner, as in COLMAP) and
// poses from the world to the camera, axes x right, y down, z forward. Names are as written in the file; points are not read.
// Which reader a file needs is decided by its content (pose_files.h).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/foundation/math/rigid.h"
#include "core/scene/camera/colmap_model.h"

namespace vitrine {

struct ProgramPoses {
  ColmapModel model;                // images in file order with ids 1, 2, ..; no points
  std::vector<std::string> places;  // of each image in the file: "camera 3", "shot", "views[3]"
  Notes notes;
};

// Cameras XML of Metashape (File > Export > Export Cameras): sensors with calibration, camera-to-chunk matrices, transforms of
// components or of the chunk. World: units of the component's transform, origin of the first component. Formulas: Metashape Pro
// manual, "Camera models". Throws Error{Input} with file, line and cause.
ProgramPoses read_metashape(const std::filesystem::path& path);
// reconstruction.json of OpenSfM and ODM: rotation vectors and translations from the world to the camera, intrinsics in units of
// the longest side. Of several reconstructions the largest.
ProgramPoses read_opensfm(const std::filesystem::path& path);
// sfm_data.json of OpenMVG (cereal): rotations from the world to the camera, and camera centres.
ProgramPoses read_openmvg(const std::filesystem::path& path);

// Parts shared by the readers.

// Radial terms 1 + k1 r^2 + k2 r^4 + k3 r^6, tangential terms in the order of OpenCV: x + 2 p1 x y + p2 (r^2 + 2 x^2).
struct BrownLens {
  double k1 = 0, k2 = 0, k3 = 0, p1 = 0, p2 = 0;
};
// The simplest of PINHOLE, OPENCV and FULL_OPENCV with this lens; id 0.
ColmapCamera brown_camera(const Intrinsics& intrinsics, const BrownLens& lens);
// Id of an equal camera of the model; else it is added.
uint32_t camera_id_of(ColmapModel& model, ColmapCamera camera);
void add_pose(ProgramPoses& poses, const Rigid& cam_from_world, uint32_t camera_id, std::string name, std::string place);
// Why the matrix is no rotation (up to rounding); nullptr: it is one. Then `nearest_rotation` removes the rounding.
const char* why_no_rotation(const Mat3d& m);
Mat3d nearest_rotation(const Mat3d& m);

}  // namespace vitrine
