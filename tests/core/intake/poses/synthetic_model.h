// Models made of cameras and points that we place ourselves: every observation is an exact projection.
#pragma once

#include <cmath>
#include <numbers>

#include "core/foundation/base/rng.h"
#include "core/scene/camera/colmap_model.h"

namespace vitrine {

// World-from-camera rotation that looks from `centre` to `target`, level with respect to `up`, rolled by `roll_rad`.
inline Rigid camera_looking(const Vec3d& centre, const Vec3d& target, const Vec3d& up, double roll_rad = 0) {
  const Vec3d forward = normalized(target - centre);
  const Vec3d right = normalized(cross(forward, up));
  const Vec3d down = cross(forward, right);
  const double c = std::cos(roll_rad), s = std::sin(roll_rad);
  return inverse(Rigid{Mat3d{c * right + s * down, c * down - s * right, forward}, centre});
}

inline ColmapModel synthetic_model(const std::vector<Rigid>& cameras, const std::vector<Vec3d>& points,
                                   const ColmapCamera& camera = {1, 1, 640, 480, {600, 600, 320, 240}}) {
  ColmapModel m;
  m.cameras.push_back(camera);
  for (size_t p = 0; p < points.size(); ++p) {
    ColmapPoint3D point;
    point.id = p + 1;
    point.position = points[p];
    point.error_px = 0.5;
    m.points.push_back(point);
  }
  for (size_t i = 0; i < cameras.size(); ++i) {
    ColmapImage image;
    image.id = static_cast<uint32_t>(i) + 1;
    image.camera_id = camera.id;
    image.name = "photo_" + std::to_string(100 + i) + ".jpg";
    image.rotation = quaternion(cameras[i].rotation);
    image.translation = cameras[i].translation;
    image.points.push_back({1, 1, kNoPoint3D});  // every photo has features without a point
    for (ColmapPoint3D& point : m.points) {
      const Vec3d q = cameras[i] * point.position;
      if (q.z <= 0) continue;
      const Vec2d pixel = project(camera, {q.x / q.z, q.y / q.z});
      if (pixel.x < 0 || pixel.y < 0 || pixel.x > double(camera.width) || pixel.y > double(camera.height)) continue;
      point.track.push_back({image.id, static_cast<uint32_t>(image.points.size())});
      image.points.push_back({pixel.x, pixel.y, point.id});
    }
    m.images.push_back(std::move(image));
  }
  std::erase_if(m.points, [&](const ColmapPoint3D& p) {
    if (p.track.size() >= 2) return false;
    for (const ColmapTrackElement& t : p.track) m.images[t.image_id - 1].points[t.point2d_index].point3d_id = kNoPoint3D;
    return true;
  });
  return m;
}

inline std::vector<Vec3d> cloud(size_t n, uint64_t seed, double half = 0.5) {
  std::vector<Vec3d> out;
  for (size_t i = 0; i < n; ++i) {
    Rng rng(seed, i);
    const double x = rng.uniform_double(), y = rng.uniform_double(), z = rng.uniform_double();
    out.push_back({half * (2 * x - 1), half * (2 * y - 1), half * (2 * z - 1)});
  }
  return out;
}

// Cameras on a circle of `radius` and `height` above the target, level, around `up`.
inline std::vector<Rigid> ring(size_t n, double radius, double height, const Vec3d& up, double roll_rad = 0,
                               double turn = 2 * std::numbers::pi) {
  const Vec3d a = normalized(cross(up, std::abs(up.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})), b = cross(up, a);
  std::vector<Rigid> out;
  for (size_t i = 0; i < n; ++i) {
    Rng rng(7, i);
    const double angle = turn * double(i) / double(n), roll = roll_rad * (2 * rng.uniform_double() - 1);
    out.push_back(camera_looking(radius * std::cos(angle) * a + radius * std::sin(angle) * b + height * up, {}, up, roll));
  }
  return out;
}

}  // namespace vitrine
