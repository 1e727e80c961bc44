// An object on a plate that turns with it, photographed by a camera that stands still in a room: drawn analytically in the frame
// of the object, in which the room turns. Written as artifacts of sfm and masks; the masks leave the plate out.
#pragma once

#include <cmath>
#include <numbers>

#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/foundation/math/color.h"

namespace vitrine::testing {

struct TurntableCapture {
  bool room_turns_along = false;  // then everything stands still: a camera that walks around
  bool plate = true;              // else the object hovers
  bool points_around = true;      // sfm found points around the object, too
  bool plain_plate = false;       // white, but for a ruler and its dark rim
  bool plain_room = false;        // one backdrop of one colour, which gets darker towards its borders
  double shake = 0;               // the camera is held in the hand: radians by which it sways about the room
  int photos = 24, width = 96, height = 72;
  uint64_t seed = 1;

  enum class Surface : unsigned char { Room, Plate, Object };
  struct Hit {
    Surface surface = Surface::Room;
    double t = 0;
    Vec3d position, color;
  };

  static constexpr double kBall = 0.28, kPlate = 0.55, kFloor = -0.12, kWall = 2.6;
  static constexpr Vec3d kBallCentre{0, 0, 0.27};

  // Smooth noise of three scales, a colour.
  Vec3d paint(double x, double y, uint64_t surface) const {
    Vec3d color;
    for (size_t c = 0; c < 3; ++c) {
      double sum = 0.35;
      for (int octave = 0; octave < 3; ++octave) {
        const double f = 4.0 * (1 << octave), px = x * f, py = y * f;
        const auto value = [&](int64_t i, int64_t j) {
          const uint64_t cell = mix64(uint64_t(i + 4096), uint64_t(j + 4096));
          return Rng(mix64(seed, surface), cell + uint64_t(octave) * 8 + (c == 0 ? 0 : c)).uniform_double() - 0.5;
        };
        const auto i = int64_t(std::floor(px)), j = int64_t(std::floor(py));
        const double u = px - double(i), v = py - double(j);
        sum += 0.3 * ((1 - v) * ((1 - u) * value(i, j) + u * value(i + 1, j)) +
                      v * ((1 - u) * value(i, j + 1) + u * value(i + 1, j + 1)));
      }
      color[c] = std::clamp(sum, 0.02, 0.95);
    }
    return color;
  }

  // Of the camera about the object, and of the room about the object.
  double turn(int photo) const { return 2 * std::numbers::pi * photo / photos; }
  double turn_of_room(int photo) const { return turn(photo) + shake * std::sin(2.3 * photo + 1); }
  View view(int photo) const {
    const double height_above = photo % 2 ? 0.85 : 0.55, azimuth = turn(photo);
    const Vec3d eye{std::cos(azimuth), std::sin(azimuth), height_above}, target{0, 0, 0.12};
    const Vec3d forward = normalized(target - eye), right = normalized(cross(forward, Vec3d{0, 0, 1}));
    View view;
    view.name = fmt::format("view_{:02}.png", photo);
    view.intrinsics = {width, height, 0.85 * width, 0.85 * width, 0.5 * width, 0.5 * height};
    view.cam_from_world = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, eye});
    return view;
  }

  Hit trace(int photo, const Vec3d& eye, const Vec3d& d) const {
    Hit hit;
    const Vec3d to = eye - kBallCentre;
    const double b = dot(to, d), root = b * b - dot(to, to) + kBall * kBall;
    const double at_ball = root > 0 ? -b - std::sqrt(root) : -1;
    const double at_plate = d.z < 0 ? -eye.z / d.z : -1;
    const Vec3d on_plate = eye + at_plate * d;
    if (at_ball > 0) {
      hit = {Surface::Object, at_ball, eye + at_ball * d, {}};
      const Vec3d n = normalized(hit.position - kBallCentre);
      hit.color = paint(std::atan2(n.y, n.x) * 0.45, std::asin(n.z) * 0.45, 1);
      return hit;
    }
    const double r = std::hypot(on_plate.x, on_plate.y);
    if (plate && at_plate > 0 && r < kPlate) {
      hit = {Surface::Plate, at_plate, on_plate, paint(on_plate.x, on_plate.y, 2)};
      if (plain_plate) {
        const bool ruler = std::abs(on_plate.y - 0.38) < 0.04 && std::abs(on_plate.x) < 0.25;
        hit.color = r > 0.97 * kPlate ? Vec3d{0.03, 0.03, 0.03}
                    : ruler           ? (int(std::floor(on_plate.x * 20)) % 2 ? Vec3d{0.05, 0.05, 0.05} : Vec3d{0.5, 0.5, 0.4})
                                      : Vec3d{0.8, 0.8, 0.77};
      }
      return hit;
    }
    // The room: a floor and a round wall, which in this frame turn with the camera.
    const double a = room_turns_along ? 0 : -turn_of_room(photo), at_floor = d.z < 0 ? (kFloor - eye.z) / d.z : 1e9;
    const double qa = d.x * d.x + d.y * d.y, qb = eye.x * d.x + eye.y * d.y, qc = eye.x * eye.x + eye.y * eye.y - kWall * kWall;
    const double at_wall = (-qb + std::sqrt(qb * qb - qa * qc)) / qa;
    hit.t = std::min(at_floor, at_wall);
    hit.position = eye + hit.t * d;
    const double x = std::cos(a) * hit.position.x - std::sin(a) * hit.position.y,
                 y = std::sin(a) * hit.position.x + std::cos(a) * hit.position.y;
    hit.color = at_floor < at_wall ? paint(0.7 * x, 0.7 * y, 3) : paint(kWall * 0.4 * std::atan2(y, x), 0.4 * hit.position.z, 4);
    if (plain_room) {
      const double fall = 0.75 + 0.1 * dot(d, normalized(Vec3d{-eye.x, -eye.y, -0.5}));
      hit.color = {fall, fall, 0.97 * fall};
    }
    return hit;
  }

  Hit trace_pixel(int photo, const View& v, double x, double y) const {
    const Rigid world_from_cam = inverse(v.cam_from_world);
    return trace(photo, world_from_cam.translation, normalized(world_from_cam.rotation * v.intrinsics.ray(x, y)));
  }

  // What each pixel's centre shows; [h*w].
  std::vector<Surface> surfaces(int photo, int w, int h) const {
    View v = view(photo);
    v.intrinsics = v.intrinsics.scaled_to(w, h);
    std::vector<Surface> shown;
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) shown.push_back(trace_pixel(photo, v, x + 0.5, y + 0.5).surface);
    return shown;
  }

  void write(const fs::path& sfm, const fs::path& masks) const {
    constexpr int kSamples = 3;
    ColmapModel model;
    Gains gains;
    std::vector<View> views;
    for (int i = 0; i < photos; ++i) views.push_back(view(i));
    parallel_for(size_t(photos), 1, [&](size_t i) {
      const View& v = views[i];
      ImageF photo(width, height, 3);
      Image8 mask(width, height, 1);
      Rng noise(seed, 77 + i);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          int inside = 0;
          Vec3d sum{};
          for (int s = 0; s < kSamples * kSamples; ++s) {
            const Hit hit = trace_pixel(int(i), v, x + (s % kSamples + 0.5) / kSamples, y + (s / kSamples + 0.5) / kSamples);
            sum += hit.color;
            inside += hit.surface == Surface::Object;
          }
          for (size_t c = 0; c < 3; ++c)
            photo.at(x, y, int(c)) = float(std::max(0.0, sum[c] / (kSamples * kSamples) + 0.004 * noise.normal()));
          mask.at(x, y) = 2 * inside > kSamples * kSamples ? 255 : 0;
        }
      write_exr_rgb(linear_image_path(sfm, v), photo);
      write_ldr(masks / "masks/object" / (v.stem() + ".png"), mask);
    });
    for (int i = 0; i < photos; ++i) {
      const View& v = views[size_t(i)];
      const Intrinsics& k = v.intrinsics;
      const auto id = static_cast<uint32_t>(i + 1);
      model.cameras.push_back({id, 1, uint64_t(width), uint64_t(height), {k.fx, k.fy, k.cx, k.cy}});
      model.images.push_back({id, quaternion(v.cam_from_world.rotation), v.cam_from_world.translation, id, v.name, {}});
      gains[v.name] = v.gain;
    }
    Rng rng(seed, 5);
    for (int n = 0; n < 24 * photos; ++n) {
      const int from = n % photos;
      const Hit hit = trace_pixel(from, views[size_t(from)], rng.uniform_double() * width, rng.uniform_double() * height);
      if (hit.surface == Surface::Room && !room_turns_along) continue;  // nothing there could be triangulated
      if (hit.surface != Surface::Object && !points_around) continue;
      ColmapPoint3D point;
      point.id = uint64_t(n) + 1;
      for (size_t c = 0; c < 3; ++c) {
        point.position[c] = hit.position[c] + 0.003 * rng.normal();
        point.srgb[c] = static_cast<uint8_t>(std::lround(255 * srgb_from_linear(float(hit.color[c]))));
      }
      std::vector<std::pair<size_t, ColmapPoint2D>> seen;
      for (size_t i = 0; i < views.size(); ++i) {
        const Vec3d p = views[i].cam_from_world * hit.position;
        const Intrinsics& k = views[i].intrinsics;
        const double x = k.fx * p.x / p.z + k.cx, y = k.fy * p.y / p.z + k.cy;
        if (!(p.z > 0 && x >= 0 && y >= 0 && x < k.width && y < k.height)) continue;
        if (length(trace_pixel(int(i), views[i], x, y).position - hit.position) < 0.02) seen.push_back({i, {x, y, point.id}});
      }
      if (seen.size() < 2) continue;
      for (const auto& [i, at] : seen) {
        point.track.push_back({model.images[i].id, static_cast<uint32_t>(model.images[i].points.size())});
        model.images[i].points.push_back(at);
      }
      model.points.push_back(point);
    }
    write_colmap_model(sfm / "sparse/0", model, ColmapFormat::Binary);
    write_gains(sfm / "sfm/gains.json", gains);
    write_scene_info(sfm / "scene.json", {});
  }
};

}  // namespace vitrine::testing
