#include "stages/evaluate/depth_buffer.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vitrine {
namespace {

constexpr double kNear_rel = 1e-4;  // near plane, relative to the distance of the mesh's farthest vertex

struct ScreenVertex {
  double x, y, inverse_z;
};

void fill_triangle(const ScreenVertex& a, const ScreenVertex& b, const ScreenVertex& c, ImageF& zdepth) {
  const double area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  if (!(std::abs(area) > 1e-12)) return;
  const auto first = [](double low, int limit) { return int(std::clamp(std::ceil(low - 0.5), 0.0, double(limit))); };
  const auto last = [](double high, int limit) { return int(std::clamp(std::floor(high - 0.5), -1.0, double(limit - 1))); };
  const int x0 = first(std::min({a.x, b.x, c.x}), zdepth.width()), x1 = last(std::max({a.x, b.x, c.x}), zdepth.width());
  const int y0 = first(std::min({a.y, b.y, c.y}), zdepth.height()), y1 = last(std::max({a.y, b.y, c.y}), zdepth.height());
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double px = x + 0.5, py = y + 0.5;
      const double wb = ((px - a.x) * (c.y - a.y) - (py - a.y) * (c.x - a.x)) / area;
      const double wc = ((b.x - a.x) * (py - a.y) - (b.y - a.y) * (px - a.x)) / area;
      const double wa = 1 - wb - wc;
      if (wa < 0 || wb < 0 || wc < 0) continue;
      const float z = float(1 / (wa * a.inverse_z + wb * b.inverse_z + wc * c.inverse_z));
      float& old = zdepth.at(x, y);
      if (old == 0 || z < old) old = z;
    }
}

}  // namespace

ImageF mesh_zdepth(const TriMesh& mesh, const Intrinsics& k, const Rigid& cam_from_world) {
  ImageF zdepth(k.width, k.height, 1);
  std::vector<Vec3d> in_cam(mesh.positions.size());
  double farthest = 0;
  for (size_t i = 0; i < in_cam.size(); ++i) {
    const Vec3f& p = mesh.positions[i];
    in_cam[i] = cam_from_world * Vec3d{p.x, p.y, p.z};
    farthest = std::max(farthest, in_cam[i].z);
  }
  const double near_z = kNear_rel * farthest;
  const auto on_screen = [&](const Vec3d& in_camera) {
    const ImagePoint p = projected(in_camera, k);
    return ScreenVertex{p.x, p.y, 1 / p.z};
  };
  for (const auto& face : mesh.faces) {
    const std::array<Vec3d, 3> v{in_cam[face[0]], in_cam[face[1]], in_cam[face[2]]};
    if (v[0].z <= near_z && v[1].z <= near_z && v[2].z <= near_z) continue;
    std::array<Vec3d, 4> polygon;  // a triangle cut by one plane has at most four corners
    size_t corners = 0;
    for (size_t i = 0; i < 3; ++i) {
      const Vec3d &p = v[i], &q = v[(i + 1) % 3];
      if (p.z > near_z) polygon[corners++] = p;
      if ((p.z > near_z) != (q.z > near_z)) {
        Vec3d cut = p + ((near_z - p.z) / (q.z - p.z)) * (q - p);
        cut.z = near_z;
        polygon[corners++] = cut;
      }
    }
    for (size_t i = 2; i < corners; ++i)
      fill_triangle(on_screen(polygon[0]), on_screen(polygon[i - 1]), on_screen(polygon[i]), zdepth);
  }
  return zdepth;
}

bool agrees_with(const ImageF& zdepth, const ImagePoint& p, double tolerance_rel) {
  const int x0 = int(std::floor(p.x - 0.5)), y0 = int(std::floor(p.y - 0.5));
  for (int y = std::max(y0, 0); y <= std::min(y0 + 1, zdepth.height() - 1); ++y)
    for (int x = std::max(x0, 0); x <= std::min(x0 + 1, zdepth.width() - 1); ++x) {
      const double z = zdepth.at(x, y);
      if (z > 0 && std::abs(p.z - z) <= tolerance_rel * z) return true;
    }
  return false;
}

}  // namespace vitrine
