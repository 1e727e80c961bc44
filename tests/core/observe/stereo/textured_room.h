// Photos of a textured table before a textured wall, drawn analytically: what a ray meets is known exactly.
#pragma once

#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "core/foundation/base/rng.h"
#include "core/observe/stereo/patch_match.h"

namespace vitrine::textured_room {

// Smooth noise of three scales.
inline double texture(double x, double y, uint64_t seed) {
  double sum = 0.5;
  for (int octave = 0; octave < 3; ++octave) {
    const double f = 9.0 * (1 << octave), px = x * f, py = y * f;
    const auto value = [&](int64_t i, int64_t j) {
      return Rng(seed, mix64(uint64_t(i + 4096), uint64_t(j + 4096)) + uint64_t(octave)).uniform_double() - 0.5;
    };
    const int64_t i = int64_t(std::floor(px)), j = int64_t(std::floor(py));
    const double u = px - double(i), v = py - double(j);
    sum += 0.3 *
           ((1 - v) * ((1 - u) * value(i, j) + u * value(i + 1, j)) + v * ((1 - u) * value(i, j + 1) + u * value(i + 1, j + 1)));
  }
  return std::clamp(sum, 0.0, 1.0);
}

struct Hit {
  double t = 0;
  Vec3d normal;
  double brightness = 0;
};

constexpr double kSky = 1e9;  // how far it is

// The floor z = 0 and the wall x = -0.5; plaster without texture above `plain_from`, the sky above `sky_from`.
inline Hit trace(const Vec3d& origin, const Vec3d& d, double plain_from, double sky_from) {
  const double floor = d.z < 0 ? -origin.z / d.z : 1e9, wall = d.x < 0 ? (-0.5 - origin.x) / d.x : 1e9;
  if (floor < wall) {
    const Vec3d p = origin + floor * d;
    return {floor, {0, 0, 1}, texture(p.x, p.y, 7)};
  }
  const Vec3d p = origin + wall * d;
  if (!(wall < 1e9) || p.z > sky_from) {
    const Vec3d u = normalized(d);
    return {kSky, -1.0 * u, texture(0.6 * std::atan2(u.y, u.x), 0.6 * std::asin(u.z), 9)};
  }
  return {wall, {1, 0, 0}, p.z > plain_from ? 0.5 : texture(p.y, p.z, 8)};
}

inline Rigid looking_at(const Vec3d& centre, const Vec3d& target) {
  const Vec3d forward = normalized(target - centre), right = normalized(cross(forward, Vec3d{0, 0, 1})),
              down = cross(forward, right);
  const Mat3d rotation = transposed(Mat3d{right, down, forward});
  return {rotation, -(rotation * centre)};
}

inline std::vector<StereoPhoto> photos(double plain_from = 1e9, double sky_from = 1e9) {
  std::vector<StereoPhoto> list;
  for (uint32_t v = 0; v < 5; ++v) {
    const double azimuth = 0.14 * (double(v) - 2);
    StereoPhoto photo;
    photo.view.name = fmt::format("view_{}.png", v);
    photo.view.intrinsics = {96, 72, 95, 95, 47, 37};
    photo.view.cam_from_world = looking_at({std::cos(azimuth), std::sin(azimuth), 0.7}, {-0.2, 0, 0.15});
    photo.near_z = 0.4, photo.far_z = 4;
    const Intrinsics& k = photo.view.intrinsics;
    const Rigid world_from_cam = inverse(photo.view.cam_from_world);
    photo.luma = ImageF(k.width, k.height, 1);
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        const Vec3d d = world_from_cam.rotation * k.ray(x + 0.5, y + 0.5);
        photo.luma.at(x, y) = float(trace(world_from_cam.translation, d, plain_from, sky_from).brightness);
      }
    for (uint32_t n = 0; n < 5; ++n)
      if (n != v) photo.neighbours.push_back(n);
    list.push_back(std::move(photo));
  }
  return list;
}

// z-depth and normal (camera frame) of what pixel (x, y) sees.
inline Hit truth(const StereoPhoto& photo, int x, int y, double sky_from = 1e9) {
  const Rigid world_from_cam = inverse(photo.view.cam_from_world);
  Hit hit =
      trace(world_from_cam.translation, world_from_cam.rotation * photo.view.intrinsics.ray(x + 0.5, y + 0.5), 1e9, sky_from);
  hit.normal = photo.view.cam_from_world.rotation * hit.normal;
  return hit;
}

}  // namespace vitrine::textured_room
