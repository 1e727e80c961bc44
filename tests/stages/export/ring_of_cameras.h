// Three pinhole cameras around the middle of the scene, and a bar as somebody would mark it in their photos.
#pragma once

#include <cmath>
#include <string>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/projection.h"

namespace vitrine::test {

inline ColmapModel ring_of_cameras() {
  ColmapModel model;
  model.cameras.push_back(colmap_pinhole(1, {640, 480, 600, 600, 320, 240}));
  for (uint32_t i = 0; i < 3; ++i) {
    const double a = 0.5 * i;
    const Vec3d eye{std::cos(a), std::sin(a), 0.6}, forward = normalized(-eye);
    const Vec3d right = normalized(cross(forward, Vec3d{0, 0, 1}));
    const Rigid pose = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, eye});
    model.images.push_back({i + 1, quaternion(pose.rotation), pose.translation, 1, fmt::format("ring {}.jpg", i), {}});
  }
  return model;
}

// Without the length: "ring 0.jpg:1,2,3,4 ring 1.jpg:..."
inline std::string marked_bar(const ColmapModel& model, const Vec3d (&ends)[2]) {
  std::string text;
  for (const ColmapImage& image : model.images) {
    const View view{image.name, pinhole_part(*model.find_camera(image.camera_id)), image.cam_from_world()};
    const auto a = projection(ends[0], view), b = projection(ends[1], view);
    text += fmt::format("{}{}:{:.3f},{:.3f},{:.3f},{:.3f}", text.empty() ? "" : " ", image.name, a->x, a->y, b->x, b->y);
  }
  return text;
}

}  // namespace vitrine::test
