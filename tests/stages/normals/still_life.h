// A painted ball and a mirror ball on a painted table, photographed from around: every pixel's normal is known exactly. The
// mirror ball shows a colour that changes with the direction of view, as no stereo can match.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "tests/support/written_objects.h"

namespace vitrine::test {

inline double degrees(const Vec3f& a, const Vec3f& b) {
  return std::acos(std::clamp(double(dot(normalized(a), normalized(b))), -1.0, 1.0)) * 180 / std::numbers::pi;
}

inline double noise(const Vec3d& p, double frequency, uint64_t seed) {
  const Vec3d q = frequency * p + Vec3d{500, 500, 500};
  const int64_t i = int64_t(q.x), j = int64_t(q.y), k = int64_t(q.z);
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const int64_t a = i + (corner & 1), b = j + (corner >> 1 & 1), c = k + (corner >> 2 & 1);
    const double weight = (1 - std::abs(q.x - double(a))) * (1 - std::abs(q.y - double(b))) * (1 - std::abs(q.z - double(c)));
    sum += weight * Rng(seed, mix64(uint64_t(a), mix64(uint64_t(b), uint64_t(c)))).uniform_double();
  }
  return sum;
}

class StillLife {
 public:
  static constexpr int kWidth = 96, kHeight = 72;
  enum Surface { Nothing, Table, Ball, Mirror };
  struct Point {
    Surface surface = Nothing;
    Vec3d position{}, normal{};
  };

  explicit StillLife(int photos = 12) {
    make_folders(sfm() / "sparse/0");
    make_folders(sfm() / "linear");
    make_folders(sfm() / "sfm");
    make_folders(masks() / "masks/specular");
    ColmapModel model;
    Gains gains;
    const Intrinsics k{kWidth, kHeight, 104, 104, 49, 35};
    model.cameras.push_back(colmap_pinhole(1, k));
    for (int i = 0; i < photos; ++i) {
      const double azimuth = 2 * std::numbers::pi * i / photos, elevation = i % 2 == 0 ? 0.45 : 0.75;
      View v;
      v.name = fmt::format("view_{:02}.png", i);
      v.intrinsics = k;
      const Vec3d centre =
          1.0 * Vec3d{std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation), std::sin(elevation)};
      const Vec3d forward = normalized(Vec3d{0, 0, 0.05} - centre), right = normalized(cross(forward, Vec3d{0, 0, 1}));
      v.cam_from_world = inverse(Rigid{Mat3d{right, cross(forward, right), forward}, centre});
      views.push_back(v);
      gains[v.name] = {1, 1, 1};
      model.images.push_back(
          {uint32_t(i + 1), quaternion(v.cam_from_world.rotation), v.cam_from_world.translation, 1, v.name, {}});
    }
    add_points(model);
    write_colmap_model(sfm() / "sparse/0", model, ColmapFormat::Binary);
    write_gains(sfm() / "sfm/gains.json", gains);
    write_scene_info(sfm() / "scene.json", SceneInfo{});
    parallel_for(views.size(), 1, [&](size_t i) { write_photo(i); });
    SurfaceOfRevolution ball{{0.2, -0.05, 0.14}, {0, 0, 1}, {}};
    for (int i = 0; i <= 48; ++i)
      ball.profile.push_back({0.14 * std::sin(std::numbers::pi * i / 48), -0.14 * std::cos(std::numbers::pi * i / 48)});
    write_objects_artifact(objects(), masks(), views, one_object(ball, ObjectRole::Mirror, 0.01));
  }

  fs::path sfm() const { return folder.path() / "sfm"; }
  fs::path masks() const { return folder.path() / "masks"; }
  fs::path objects() const { return folder.path() / "objects"; }  // an artifact: the mirror ball

  static Point seen(const Vec3d& o, const Vec3d& d) {
    Point best;
    double nearest = 1e300;
    if (const double t = -o.z / d.z; t > 0 && length(o + t * d) < 1.2) best = {Table, o + t * d, {0, 0, 1}}, nearest = t;
    const Vec3d centres[] = {{-0.16, 0.02, 0.15}, {0.2, -0.05, 0.14}};
    const double radii[] = {0.15, 0.14};
    for (size_t s = 0; s < 2; ++s) {
      const Vec3d to = o - centres[s];
      const double a = dot(d, d), b = dot(to, d), root = b * b - a * (dot(to, to) - radii[s] * radii[s]);
      if (root <= 0) continue;
      const double t = (-b - std::sqrt(root)) / a;
      if (t <= 0 || t >= nearest) continue;
      nearest = t;
      best = {s == 0 ? Ball : Mirror, o + t * d, (1 / radii[s]) * (o + t * d - centres[s])};
    }
    return best;
  }
  Point at(size_t view, double x, double y) const {
    const Rigid world_from_cam = inverse(views[view].cam_from_world);
    return seen(world_from_cam.translation, world_from_cam.rotation * views[view].intrinsics.ray(x, y));
  }
  // Camera frame; 0 where there is nothing.
  Vec3f normal(size_t view, double x, double y) const {
    return cast<float>(views[view].cam_from_world.rotation * at(view, x, y).normal);
  }

  TemporaryFolder folder;
  std::vector<View> views;

 private:
  void add_points(ColmapModel& model) {
    Rng rng(3);
    for (uint64_t id = 1; id < 400; ++id) {
      const uint32_t view = rng.below(uint32_t(views.size()));
      const Point p = at(view, kWidth * rng.uniform_double(), kHeight * rng.uniform_double());
      if (p.surface != Table && p.surface != Ball) continue;
      ColmapPoint3D point{id, p.position, {128, 128, 128}, 0.5, {}};
      for (size_t v = 0; v < views.size(); ++v) {
        const Vec3d q = views[v].cam_from_world * p.position;
        const Intrinsics& k = views[v].intrinsics;
        const double x = k.fx * q.x / q.z + k.cx, y = k.fy * q.y / q.z + k.cy;
        if (!(q.z > 0 && x > 0 && y > 0 && x < kWidth && y < kHeight)) continue;
        const Point first = at(v, x, y);
        if (length(first.position - p.position) > 1e-3) continue;
        model.images[v].points.push_back({x, y, id});
        point.track.push_back({uint32_t(v + 1), uint32_t(model.images[v].points.size() - 1)});
      }
      if (point.track.size() > 1) {
        model.points.push_back(point);
        continue;
      }
      for (const ColmapTrackElement& t : point.track) model.images[t.image_id - 1].points.pop_back();
    }
  }

  void write_photo(size_t v) const {
    ImageF photo(kWidth, kHeight, 3);
    Image8 mirror(kWidth, kHeight, 1);
    const Vec3d eye = views[v].centre_in_world();
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const Point p = at(v, x + 0.5, y + 0.5);
        double value = 0.1;
        if (p.surface == Table || p.surface == Ball)
          value = 0.02 + 0.3 * noise(p.position, 18, 1) + 0.3 * noise(p.position, 45, 2) + 0.2 * noise(p.position, 80, 3);
        if (p.surface == Mirror) {
          const Vec3d ray = normalized(p.position - eye), out = ray - 2 * dot(ray, p.normal) * p.normal;
          value = 0.1 + 0.8 * noise(out, 4, 4);
          mirror.at(x, y) = 255;
        }
        for (int c = 0; c < 3; ++c) photo.at(x, y, c) = float(value * (p.surface == Ball && c == 2 ? 0.5 : 1));
      }
    write_exr_rgb(linear_image_path(sfm(), views[v]), photo);
    write_ldr(masks() / "masks/specular" / (views[v].stem() + ".png"), mirror);
  }
};

}  // namespace vitrine::test
