#include "core/intake/poses/colmap_repair.h"

#include <algorithm>
#include <map>
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

ColmapModel compacted(ColmapModel model, const std::function<bool(const ColmapPoint3D&)>& keep) {
  std::map<uint32_t, size_t> image_at;
  for (size_t i = 0; i < model.images.size(); ++i) image_at[model.images[i].id] = i;
  // New index of every 2D point that still has a 3D point.
  constexpr uint32_t kGone = ~uint32_t{0};
  std::vector<std::vector<uint32_t>> new_index(model.images.size());
  std::vector<ColmapPoint3D> kept;
  for (ColmapPoint3D& p : model.points) {
    std::erase_if(p.track, [&](const ColmapTrackElement& t) {
      return model.images[image_at.at(t.image_id)].points[t.point2d_index].point3d_id != p.id;
    });
    if (!keep(p)) {
      for (const ColmapTrackElement& t : p.track)
        model.images[image_at.at(t.image_id)].points[t.point2d_index].point3d_id = kNoPoint3D;
      continue;
    }
    const uint64_t id = kept.size() + 1;
    for (const ColmapTrackElement& t : p.track) {
      ColmapImage& image = model.images[image_at.at(t.image_id)];
      std::vector<uint32_t>& index = new_index[image_at.at(t.image_id)];
      index.resize(image.points.size(), kGone);
      index[t.point2d_index] = 0;  // marked; numbered below
    }
    p.id = id;
    kept.push_back(std::move(p));
  }
  for (size_t i = 0; i < model.images.size(); ++i) {
    new_index[i].resize(model.images[i].points.size(), kGone);
    std::vector<ColmapPoint2D> left;
    for (size_t k = 0; k < new_index[i].size(); ++k) {
      if (new_index[i][k] == kGone) continue;
      new_index[i][k] = static_cast<uint32_t>(left.size());
      left.push_back(model.images[i].points[k]);
    }
    model.images[i].points = std::move(left);
  }
  for (ColmapPoint3D& p : kept)
    for (ColmapTrackElement& t : p.track) {
      const size_t i = image_at.at(t.image_id);
      t.point2d_index = new_index[i][t.point2d_index];
      model.images[i].points[t.point2d_index].point3d_id = p.id;
    }
  model.points = std::move(kept);
  return model;
}

ColmapModel without_images(ColmapModel model, const std::set<uint32_t>& images) {
  std::erase_if(model.images, [&](const ColmapImage& image) { return images.contains(image.id); });
  for (ColmapPoint3D& p : model.points)
    std::erase_if(p.track, [&](const ColmapTrackElement& t) { return images.contains(t.image_id); });
  model = compacted(std::move(model), [](const ColmapPoint3D& p) { return p.track.size() >= 2; });
  std::erase_if(model.cameras, [&](const ColmapCamera& camera) {
    return std::none_of(model.images.begin(), model.images.end(),
                        [&](const ColmapImage& image) { return image.camera_id == camera.id; });
  });
  return model;
}

}  // namespace vitrine
