// Photos on a ring around a cloud of points, as a mapper leaves them: 640x480 pixels of one camera.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>

#include <fmt/format.h>

#include "core/foundation/base/rng.h"
#include "core/scene/camera/colmap_model.h"

namespace vitrine::test {

inline void add_cloud(ColmapModel& model, uint64_t count, Rng& rng) {
  for (uint64_t p = 1; p <= count; ++p)
    model.points.push_back({.id = p, .position = {rng.normal() * 0.4, rng.normal() * 0.4, rng.normal() * 0.25}, .track = {}});
}

// A photo two units from the axis, towards the middle of the cloud. `pixel`: where a point of the camera frame appears, of x / z
// and y / z.
inline void add_photo(ColmapModel& model, uint32_t id, double azimuth, double height,
                      const std::function<Vec2d(double x, double y)>& pixel) {
  const Vec3d eye{2 * std::cos(azimuth), 2 * std::sin(azimuth), height};
  const Vec3d forward = normalized(-1.0 * eye), right = normalized(cross(forward, Vec3d{0, 0, 1}));
  const Rigid pose = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, eye});
  ColmapImage image{.id = id,
                    .rotation = quaternion(pose.rotation),
                    .translation = pose.translation,
                    .camera_id = 1,
                    .name = fmt::format("{:02}.jpg", id),
                    .points = {}};
  for (ColmapPoint3D& point : model.points) {
    const Vec3d q = pose * point.position;
    const Vec2d at = pixel(q.x / q.z, q.y / q.z);
    if (at.x < 0 || at.y < 0 || at.x > 640 || at.y > 480) continue;
    point.track.push_back({id, uint32_t(image.points.size())});
    image.points.push_back({at.x, at.y, point.id});
  }
  model.images.push_back(std::move(image));
}

}  // namespace vitrine::test
