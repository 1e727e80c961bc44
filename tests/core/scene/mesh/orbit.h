// Cameras around the origin that look at it, and depth maps of analytic shapes.
#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/mesh/tsdf_volume.h"

namespace vitrine::orbit {

inline Rigid looking_at(const Vec3d& centre, const Vec3d& target) {
  const Vec3d z = normalized(target - centre);
  const Vec3d x = normalized(cross(z, std::abs(z.z) < 0.99 ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0}));
  const Mat3d world_from_cam{x, cross(z, x), z};
  return {transposed(world_from_cam), -(transposed(world_from_cam) * centre)};
}

// `n` cameras per ring of elevation, `distance` from the origin.
inline std::vector<View> views(int n, const std::vector<double>& elevations_deg, double distance, int size) {
  std::vector<View> out;
  for (double elevation : elevations_deg)
    for (int i = 0; i < n; ++i) {
      const double azimuth = 2 * M_PI * (i + 0.5 * double(out.size() % 2)) / n, e = elevation * M_PI / 180;
      View v;
      v.name = "view_" + std::to_string(100 + out.size()) + ".png";
      v.intrinsics = {size, size, 1.1 * size, 1.1 * size, 0.5 * size, 0.5 * size};
      v.cam_from_world =
          looking_at(distance * Vec3d{std::cos(azimuth) * std::cos(e), std::sin(azimuth) * std::cos(e), std::sin(e)}, {0, 0, 0});
      out.push_back(v);
    }
  return out;
}

// A depth map with storage. `hit` gives, for a ray origin + t * direction (camera-z component 1), the t and the unit normal.
struct Hit {
  double t = 0;
  Vec3d normal{};
};
struct Map {
  View of;
  std::vector<float> zdepth, weight, color;
  DepthView view() const { return {of.intrinsics, of.cam_from_world, zdepth, weight, color}; }
};
inline Map map(const View& view, const std::function<std::optional<Hit>(const Vec3d& origin, const Vec3d& direction)>& hit) {
  const size_t w = size_t(view.intrinsics.width), h = size_t(view.intrinsics.height);
  Map m{view, std::vector<float>(w * h, 0.f), std::vector<float>(w * h, 0.f), std::vector<float>(3 * w * h, 0.f)};
  for (size_t y = 0; y < h; ++y)
    for (size_t x = 0; x < w; ++x) {
      const Vec3d d = view.ray(double(x) + 0.5, double(y) + 0.5);
      const auto found = hit(view.centre_in_world(), d);
      if (!found) continue;
      const size_t p = y * w + x;
      const double cosine = std::max(0.0, -dot(found->normal, d) / length(d));
      m.zdepth[p] = float(found->t);
      m.weight[p] = float(cosine * cosine / (found->t * found->t));
      for (size_t c = 0; c < 3; ++c) m.color[c * w * h + p] = float(0.5 + 0.5 * found->normal[c]);
    }
  return m;
}

inline std::optional<Hit> hit_sphere(const Vec3d& centre, double radius, const Vec3d& o, const Vec3d& d) {
  const Vec3d oc = o - centre;
  const double a = squared_length(d), b = dot(oc, d), c = squared_length(oc) - radius * radius, q = b * b - a * c;
  if (q < 0) return std::nullopt;
  const double t = (-b - std::sqrt(q)) / a;
  if (t <= 0) return std::nullopt;
  return Hit{t, normalized(o + t * d - centre)};
}
// The square |x|, |y| < half at height z, seen from above or below.
inline std::optional<Hit> hit_square(double z, double half, const Vec3d& o, const Vec3d& d) {
  const double t = (z - o.z) / d.z;
  const Vec3d p = o + t * d;
  if (!(t > 0) || std::abs(p.x) > half || std::abs(p.y) > half) return std::nullopt;
  return Hit{t, {0, 0, d.z < 0 ? 1.0 : -1.0}};
}
inline std::optional<Hit> nearer(const std::optional<Hit>& a, const std::optional<Hit>& b) {
  return !b || (a && a->t < b->t) ? a : b;
}

}  // namespace vitrine::orbit
