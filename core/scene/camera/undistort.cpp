#include "core/scene/camera/undistort.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/camera/colmap_lens.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr double kInvisible = 0.01;  // px, below the noise of SfM

constexpr double kWidest = 1.2;  // of fisheye lenses: tangent of the largest angle left, 50 degrees to each side

[[noreturn]] void throw_folds(const ColmapCamera& camera, const Vec2d& pixel) {
  throw Error(ErrorKind::Input, "the lens distortion cannot be removed",
              {.where = fmt::format("camera {}", camera.id),
               .why = fmt::format("its model folds over at pixel ({:.0f}, {:.0f})", pixel.x, pixel.y),
               .hint = "--set sfm.camera_model=SIMPLE_RADIAL, or give undistorted photos with --poses",
               .code = "SFM_BAD_DISTORTION"});
}

// Where a border pixel lands. Empty: a fisheye lens shows there what the undistorted picture leaves out.
std::optional<Vec2d> landing(const ColmapCamera& camera, const Intrinsics& pinhole, const Vec2d& pixel) {
  const std::optional<Vec2d> d = unproject(camera, pixel);
  if (is_fisheye(camera.model_id) && !(d && std::max(std::abs(d->x), std::abs(d->y)) < kWidest)) return std::nullopt;
  if (!d) throw_folds(camera, pixel);
  return Vec2d{d->x * pinhole.fx + pinhole.cx, d->y * pinhole.fy + pinhole.cy};
}

// A fisheye model may fold over between the axis and the corners of the undistorted picture.
void check_corners(const ColmapCamera& camera, const Intrinsics& target) {
  constexpr double kSame = 1e-6;
  for (const int x : {0, target.width})
    for (const int y : {0, target.height}) {
      const Vec3d ray = target.ray(x, y);
      const Vec2d pixel = project(camera, {ray.x, ray.y});
      const std::optional<Vec2d> back = unproject(camera, pixel);
      if (!back || std::hypot(back->x - ray.x, back->y - ray.y) > kSame) throw_folds(camera, pixel);
    }
}

}  // namespace

Undistortion undistortion(const ColmapCamera& camera) {
  Undistortion u{.source = camera, .target = pinhole_part(camera), .identity = !is_distorted(camera)};
  if (u.identity) return u;
  const Intrinsics pinhole = u.target;
  const double w = pinhole.width, h = pinhole.height;
  const bool fisheye = is_fisheye(camera.model_id);
  const double reach_x = fisheye ? kWidest * pinhole.fx : 1e9, reach_y = fisheye ? kWidest * pinhole.fy : 1e9;
  double left = pinhole.cx - reach_x, right = pinhole.cx + reach_x, top = pinhole.cy - reach_y, bottom = pinhole.cy + reach_y;
  double moved = fisheye ? 1 : 0;
  const auto note = [&](const Vec2d& from, auto&& limit) {
    const std::optional<Vec2d> to = landing(camera, pinhole, from);
    if (!to) return;
    moved = std::max(moved, std::hypot(to->x - from.x, to->y - from.y));
    limit(*to);
  };
  // The borders are smooth curves: sampling them at pixel steps is sufficient.
  for (int i = 0; i <= pinhole.height; ++i) {
    note({0, double(i)}, [&](const Vec2d& to) { left = std::max(left, to.x); });
    note({w, double(i)}, [&](const Vec2d& to) { right = std::min(right, to.x); });
  }
  for (int i = 0; i <= pinhole.width; ++i) {
    note({double(i), 0}, [&](const Vec2d& to) { top = std::max(top, to.y); });
    note({double(i), h}, [&](const Vec2d& to) { bottom = std::min(bottom, to.y); });
  }
  if (moved < kInvisible) {
    u.identity = true;
    return u;
  }
  const int x0 = static_cast<int>(std::ceil(left)), x1 = static_cast<int>(std::floor(right));
  const int y0 = static_cast<int>(std::ceil(top)), y1 = static_cast<int>(std::floor(bottom));
  if (2 * (x1 - x0) < pinhole.width || 2 * (y1 - y0) < pinhole.height)
    throw Error(ErrorKind::Input, "the lens distortion is implausible",
                {.where = fmt::format("camera {}", camera.id),
                 .why = fmt::format("undistorted, a photo of {} x {} pixels would keep {} x {}", pinhole.width, pinhole.height,
                                    x1 - x0, y1 - y0),
                 .hint = "--set sfm.camera_model=SIMPLE_PINHOLE",
                 .code = "SFM_BAD_DISTORTION"});
  u.target = {x1 - x0, y1 - y0, pinhole.fx, pinhole.fy, pinhole.cx - x0, pinhole.cy - y0};
  if (fisheye) check_corners(camera, u.target);
  return u;
}

ImageF undistorted(const ImageF& linear, const Undistortion& u) {
  VITRINE_CHECK(linear.width() == int(u.source.width) && linear.height() == int(u.source.height),
                "picture {} x {} for a camera of {} x {}", linear.width(), linear.height(), u.source.width, u.source.height);
  if (u.identity) return linear;
  ImageF out(u.target.width, u.target.height, linear.channels());
  if (u.rotation) {
    parallel_for(size_t(out.height()), 16, [&](size_t y) {
      for (int x = 0; x < out.width(); ++x)
        if (const std::optional<Vec2d> from = seen_pixel(u, {x + 0.5, double(y) + 0.5}))
          sample_bicubic(linear, from->x, from->y, out.pixel(x, int(y)));
    });
    return out;
  }
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x) {
      const Vec3d ray = u.target.ray(x + 0.5, y + 0.5);
      const Vec2d from = project(u.source, {ray.x, ray.y});
      sample_bicubic(linear, from.x, from.y, out.pixel(x, y));
    }
  return out;
}

std::optional<Vec2d> undistorted(const Vec2d& pixel, const Undistortion& u) {
  if (u.identity) return pixel;
  if (u.rotation) {
    constexpr double kInFront = 0.05;  // of a unit direction: its part along the axis of the view
    const std::optional<Vec3d> ray = ray_of_pixel(u.source, pixel);
    if (!ray) return std::nullopt;
    const Vec3d in_view = *u.rotation * normalized(*ray);
    if (!(in_view.z > kInFront)) return std::nullopt;
    const ImagePoint at = projected(in_view, u.target);
    return Vec2d{at.x, at.y};
  }
  const std::optional<Vec2d> d = unproject(u.source, pixel);
  if (!d) return std::nullopt;
  return Vec2d{d->x * u.target.fx + u.target.cx, d->y * u.target.fy + u.target.cy};
}

std::optional<Vec2d> seen_pixel(const Undistortion& u, const Vec2d& pixel) {
  constexpr double kSame = 1e-9;  // 1 - cosine of the angle between a direction and that of its pixel
  const Vec3d ray = normalized(transposed_times(u.rotation.value_or(Mat3d::identity()), u.target.ray(pixel.x, pixel.y)));
  const Vec2d at = project_ray(u.source, ray);
  if (!(at.x >= 0 && at.y >= 0 && at.x <= double(u.source.width) && at.y <= double(u.source.height))) return std::nullopt;
  const Intrinsics k = pinhole_part(u.source);
  if (u.circle_px > 0 && std::hypot(at.x - k.cx, at.y - k.cy) > u.circle_px) return std::nullopt;
  const std::optional<Vec3d> back = ray_of_pixel(u.source, at);
  if (!back || dot(normalized(*back), ray) < 1 - kSame) return std::nullopt;
  return at;
}

}  // namespace vitrine
