#include "core/intake/poses/colmap_repair.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

namespace vitrine {

std::string ColmapRepairs::text() const {
  std::string out;
  const auto add = [&](size_t n, const char* one, const char* many) {
    if (n > 0) out += fmt::format("{}{} {}", out.empty() ? "" : ", ", n, n == 1 ? one : many);
  };
  add(images_without_camera, "image names a camera that is not there", "images name a camera that is not there");
  add(points_gone, "2D point names a 3D point that is not there", "2D points name a 3D point that is not there");
  add(images_gone, "entry of a track names an image that is not there", "entries of tracks name an image that is not there");
  add(indices_gone, "entry of a track names a 2D point that its image does not have",
      "entries of tracks name a 2D point that their image does not have");
  add(disagreeing, "2D point and a track contradict each other", "2D points and tracks contradict each other");
  return out;
}

ColmapRepairs drop_dangling_references(ColmapModel& model) {
  ColmapRepairs repairs;
  const size_t images = model.images.size();
  std::erase_if(model.images, [&](const ColmapImage& image) { return model.find_camera(image.camera_id) == nullptr; });
  repairs.images_without_camera = images - model.images.size();
  std::vector<std::vector<bool>> in_track(model.images.size());
  for (size_t i = 0; i < model.images.size(); ++i) {
    in_track[i].resize(model.images[i].points.size());
    for (ColmapPoint2D& p : model.images[i].points)
      if (p.point3d_id != kNoPoint3D && model.find_point(p.point3d_id) == nullptr) {
        // A model without 3D points contains poses only and needs no repair.
        repairs.points_gone += !model.points.empty();
        p.point3d_id = kNoPoint3D;
      }
  }
  for (ColmapPoint3D& point : model.points)
    std::erase_if(point.track, [&](const ColmapTrackElement& e) {
      const ColmapImage* image = model.find_image(e.image_id);
      if (image == nullptr) return ++repairs.images_gone, true;
      if (e.point2d_index >= image->points.size()) return ++repairs.indices_gone, true;
      if (image->points[e.point2d_index].point3d_id != point.id) return ++repairs.disagreeing, true;
      in_track[size_t(image - model.images.data())][e.point2d_index] = true;
      return false;
    });
  for (size_t i = 0; i < model.images.size(); ++i)
    for (size_t k = 0; k < in_track[i].size(); ++k) {
      ColmapPoint2D& p = model.images[i].points[k];
      if (p.point3d_id == kNoPoint3D || in_track[i][k]) continue;
      p.point3d_id = kNoPoint3D;
      ++repairs.disagreeing;
    }
  return repairs;
}

}  // namespace vitrine
