#include "sample_data/generate/scene.h"

#include <cmath>

#include <fmt/format.h>

#include "core/foundation/base/rng.h"

namespace vitrine::generate {

void add_lamp(Scene& scene, const Lamp& lamp) {
  scene.parts.push_back({.name = fmt::format("lamp_{}", scene.lamps.size()),
                         .shape = rectangle(lamp.corner, lamp.edge_u, lamp.edge_v, 1e6f),
                         .material = {.kind = MaterialKind::Emitter},
                         .lamp = static_cast<int>(scene.lamps.size())});
  scene.lamps.push_back(lamp);
}

Rigid looking_at(const Vec3d& eye, const Vec3d& target, const Vec3d& up) {
  const Vec3d forward = normalized(target - eye);
  const Vec3d right = normalized(cross(forward, up));
  const Mat3d world_from_cam{right, cross(forward, right), forward};
  return inverse(Rigid{world_from_cam, eye});
}

void add_ring(Scene& scene, const CameraRing& ring, const Vec3d& target, const Intrinsics& intrinsics) {
  for (int i = 0; i < ring.count; ++i) {
    const size_t number = scene.views.size();
    Rng rng(ring.seed, number);
    const auto swing = [&rng] { return 2 * rng.uniform_double() - 1; };
    const double azimuth = ring.azimuth_rad + ring.span_rad * (i + 0.25 * swing()) / ring.count;
    const double elevation = ring.elevation_rad * (1 + ring.sway * swing());
    const double distance = ring.distance * (1 + ring.sway * swing());
    const Vec3d eye = target + distance * Vec3d{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                                std::sin(elevation)};
    const Vec3d aim = target + 0.4 * ring.sway * distance * Vec3d{swing(), swing(), swing()};
    const Vec3d up{0.5 * ring.sway * swing(), 0.5 * ring.sway * swing(), 1};
    scene.views.push_back({.name = fmt::format("img_{:04}{}", number, scene.sensor.extension),
                           .intrinsics = intrinsics,
                           .cam_from_world = looking_at(eye, aim, up)});
  }
}

}  // namespace vitrine::generate
