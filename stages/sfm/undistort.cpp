#include "stages/sfm/undistort.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/camera/compacted.h"

namespace vitrine {

ColmapModel undistorted(const ColmapModel& model, const std::vector<Undistortion>& per_camera) {
  VITRINE_CHECK(per_camera.size() == model.cameras.size(), "{} undistortions for {} cameras", per_camera.size(),
                model.cameras.size());
  ColmapModel out = model;
  for (size_t c = 0; c < out.cameras.size(); ++c) out.cameras[c] = colmap_pinhole(model.cameras[c].id, per_camera[c].target);
  for (ColmapImage& image : out.images) {
    const auto camera =
        std::find_if(model.cameras.begin(), model.cameras.end(), [&](const ColmapCamera& c) { return c.id == image.camera_id; });
    const Undistortion& u = per_camera[static_cast<size_t>(camera - model.cameras.begin())];
    for (ColmapPoint2D& p : image.points) {
      if (p.point3d_id == kNoPoint3D) continue;
      const std::optional<Vec2d> moved = undistorted({p.x, p.y}, u);
      if (moved) {
        p.x = moved->x;
        p.y = moved->y;
      } else {
        p.point3d_id = kNoPoint3D;
      }
    }
  }
  return compacted(std::move(out), [](const ColmapPoint3D& p) { return p.track.size() >= 2; });
}

}  // namespace vitrine
