#include "core/intake/poses/program_poses.h"

#include <algorithm>
#include <cmath>

#include "core/scene/camera/colmap_lens.h"

namespace vitrine {

ColmapCamera brown_camera(const Intrinsics& k, const BrownLens& lens) {
  ColmapCamera camera;
  camera.model_id = colmap_camera_type("FULL_OPENCV")->id;
  camera.width = static_cast<uint64_t>(k.width), camera.height = static_cast<uint64_t>(k.height);
  camera.params = {k.fx, k.fy, k.cx, k.cy, lens.k1, lens.k2, lens.p1, lens.p2, lens.k3, 0, 0, 0};
  return simplest_camera(std::move(camera));
}

uint32_t camera_id_of(ColmapModel& model, ColmapCamera camera) {
  for (const ColmapCamera& known : model.cameras) {
    camera.id = known.id;
    if (camera == known) return known.id;
  }
  camera.id = static_cast<uint32_t>(model.cameras.size()) + 1;
  model.cameras.push_back(std::move(camera));
  return model.cameras.back().id;
}

void add_pose(ProgramPoses& poses, const Rigid& cam_from_world, uint32_t camera_id, std::string name, std::string place) {
  poses.model.images.push_back({.id = static_cast<uint32_t>(poses.model.images.size()) + 1,
                                .rotation = quaternion(cam_from_world.rotation),
                                .translation = cam_from_world.translation,
                                .camera_id = camera_id,
                                .name = std::move(name),
                                .points = {}});
  poses.places.push_back(std::move(place));
}

const char* why_no_rotation(const Mat3d& m) {
  constexpr double kOrthogonal = 1e-3;
  const Mat3d square = transposed(m) * m;
  for (size_t r = 0; r < 3; ++r)
    for (size_t c = 0; c < 3; ++c)
      if (!(std::abs(square(r, c) - (r == c)) <= kOrthogonal)) return "the matrix is not a rotation";
  return determinant(m) > 0 ? nullptr : "the matrix mirrors space";
}

Mat3d nearest_rotation(const Mat3d& m) { return rotation_matrix(quaternion(m)); }

}  // namespace vitrine
