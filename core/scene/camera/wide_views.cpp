#include "core/scene/camera/wide_views.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/colmap_lens.h"

namespace vitrine {

namespace {

constexpr double kReach = 1.05;             // of a face: tangent of its half angle; faces overlap by the rest
constexpr double kLeastShare = 0.005;       // of the pixels of all faces
constexpr int kLeastSide = 8, kScan = 300;  // pixels; steps along a side when the seen part of a face is searched

// face_from_camera: ahead, right, left, down, up, behind. The rows of ahead are those of the photo.
std::array<Mat3d, 6> cube_faces() {
  const auto face = [](const Vec3d& forward, const Vec3d& down) {
    return transposed(Mat3d{cross(down, forward), down, forward});
  };
  const Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  return {face(z, y), face(x, y), face(-x, y), face(y, -z), face(-y, z), face(-z, y)};
}

// Pixels a radian at the axis of the lens.
double pixels_per_radian(const ColmapCamera& camera) {
  constexpr double kSmall = 0.01;
  const Vec2d middle = project_ray(camera, {0, 0, 1}), right = project_ray(camera, {std::sin(kSmall), 0, std::cos(kSmall)}),
              below = project_ray(camera, {0, std::sin(kSmall), std::cos(kSmall)});
  return std::sqrt(std::abs((right.x - middle.x) * (below.y - middle.y))) / kSmall;
}

struct Seen {
  int left = 0, top = 0, right = 0, bottom = 0;  // crop, [left, right)
  double pixels = 0;
};
Seen seen_part(const Undistortion& u) {
  const int w = u.target.width, h = u.target.height, step = std::max({w / kScan, h / kScan, 1});
  const size_t rows = size_t((h + step - 1) / step);
  std::vector<Seen> of_row(rows);
  parallel_for(rows, 4, [&](size_t row) {
    Seen& s = of_row[row];
    s.left = w;
    for (int x = 0; x < w; x += step)
      if (seen_pixel(u, {x + 0.5, double(row) * step + 0.5}))
        s.left = std::min(s.left, x), s.right = x + 1, s.pixels += step * step;
  });
  Seen all{.left = w, .top = h};
  for (size_t row = 0; row < rows; ++row) {
    const Seen& s = of_row[row];
    if (s.pixels == 0) continue;
    all.left = std::min(all.left, s.left), all.right = std::max(all.right, s.right);
    all.top = std::min(all.top, int(row) * step), all.bottom = int(row) * step + 1;
    all.pixels += s.pixels;
  }
  const int more = step - 1;  // what lies between two steps
  return {std::max(all.left - more, 0), std::max(all.top - more, 0), std::min(all.right + more, w),
          std::min(all.bottom + more, h), all.pixels};
}

}  // namespace

double widest_field_deg(const ColmapCamera& camera, double circle_px) {
  constexpr int kSteps = 256;
  const Intrinsics k = pinhole_part(camera);
  const auto reach = [&](const Vec2d& direction, double border_px) {
    const double end = circle_px > 0 ? std::min(circle_px, border_px) : border_px;
    double widest = 0;
    for (int i = 1; i <= kSteps; ++i) {  // up to where the model folds over
      const std::optional<Vec3d> ray = ray_of_pixel(camera, Vec2d{k.cx, k.cy} + (end * i / kSteps) * direction);
      const double angle = ray ? std::atan2(std::hypot(ray->x, ray->y), ray->z) : 0;
      if (!(angle >= widest)) break;
      widest = angle;
    }
    return widest;
  };
  const double across = reach({-1, 0}, k.cx) + reach({1, 0}, k.width - k.cx);
  const double down = reach({0, -1}, k.cy) + reach({0, 1}, k.height - k.cy);
  return std::max(across, down) * 180 / std::numbers::pi;
}

std::vector<Undistortion> lens_views(const ColmapCamera& camera, double circle_px) {
  if (!is_fisheye(camera.model_id) || widest_field_deg(camera, circle_px) <= kWidestPicture_deg) return {undistortion(camera)};
  const double focal = pixels_per_radian(camera);
  const int side = 2 * int(std::ceil(kReach * focal));
  struct Face {
    Undistortion view;
    Seen seen;
  };
  std::vector<Face> faces;
  double all = 0;
  for (const Mat3d& rotation : cube_faces()) {
    Undistortion u{.source = camera,
                   .target = {side, side, focal, focal, 0.5 * side, 0.5 * side},
                   .identity = false,
                   .rotation = rotation,
                   .circle_px = circle_px};
    const Seen s = seen_part(u);
    all += s.pixels;
    faces.push_back({std::move(u), s});
  }
  std::vector<Undistortion> views;
  for (Face& face : faces) {
    const Seen& s = face.seen;
    Intrinsics& k = face.view.target;
    if (s.pixels <= kLeastShare * all || s.right - s.left < kLeastSide || s.bottom - s.top < kLeastSide) continue;
    k = {s.right - s.left, s.bottom - s.top, k.fx, k.fy, k.cx - s.left, k.cy - s.top};
    views.push_back(std::move(face.view));
  }
  return views;
}

ImageF unseen_pixels(const Undistortion& view) {
  ImageF out(view.target.width, view.target.height, 1);
  if (!view.rotation) return {};
  parallel_for(size_t(out.height()), 16, [&](size_t y) {
    for (int x = 0; x < out.width(); ++x) out.at(x, int(y)) = seen_pixel(view, {x + 0.5, double(y) + 0.5}) ? 0.f : 1.f;
  });
  return std::ranges::any_of(out.data(), [](float v) { return v > 0; }) ? out : ImageF();
}

std::string view_name(const std::string& folder, const std::string& photo, size_t view) {
  return fmt::format("{}/view_{:02}{}", folder, view, std::filesystem::path(photo).extension().string());
}

std::vector<std::string> view_folders(std::span<const std::string> stems) {
  std::set<std::string> taken;
  for (const std::string& stem : stems)
    for (std::filesystem::path folder = std::filesystem::path(stem).parent_path(); !folder.empty(); folder = folder.parent_path())
      taken.insert(folder.generic_string());
  std::vector<std::string> folders;
  for (const std::string& stem : stems) {
    std::string& folder = folders.emplace_back(stem);
    while (!taken.insert(folder).second) folder += '_';
  }
  return folders;
}

}  // namespace vitrine
