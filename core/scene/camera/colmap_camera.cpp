// Projection with the supported COLMAP camera models. With (u, v) the ideal direction and r2 = u^2 + v^2:
//   SIMPLE_RADIAL, RADIAL:  d = (k1 r2 + k2 r2^2) (u, v)
//   OPENCV:                 d = (k1 r2 + k2 r2^2) (u, v) + (2 p1 u v + p2 (r2 + 2 u^2), 2 p2 u v + p1 (r2 + 2 v^2))
//   FULL_OPENCV:            OPENCV with the radial factor (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
//   fisheye models:         (u, v) is first scaled to the angle theta = atan(r) from the axis; then OPENCV_FISHEYE,
//   RADIAL_FISHEYE:
//                           d = (k1 r2 + k2 r2^2 + k3 r2^3 + k4 r2^4) (u, v); THIN_PRISM_FISHEYE: with the terms of p1, p2 and
//                           (s1 r2, s2 r2)
//   FOV:                    (u, v) is scaled to the length atan(2 r tan(omega / 2)) / omega (Devernay and Faugeras 2001)
//   pixel = f (u + d_u, v + d_v) + c
// (COLMAP, src/colmap/sensor/models.h)
#include <cmath>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/scene/camera/colmap_lens.h"

namespace vitrine {

namespace {

enum Model { kSimplePinhole = 0, kPinhole = 1, kSimpleRadial = 2, kRadial = 3, kOpenCv = 4, kFullOpenCv = 6 };
enum WideModel { kOpenCvFisheye = 5, kFov = 7, kSimpleRadialFisheye = 8, kRadialFisheye = 9, kThinPrismFisheye = 10 };
enum class Bend { None, Fisheye, Fov };  // of directions, before the polynomial

constexpr double kLeastOmega = 1e-8;   // of FOV: below, the lens is a pinhole
constexpr double kWidestAngle = 1.55;  // from the axis, radians: there a direction (x, y, 1) is 48 long

struct Lens {
  double fx, fy, cx, cy;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  double k3 = 0, k4 = 0, k5 = 0, k6 = 0;
  Bend bend = Bend::None;
  double fourth = 0, s1 = 0, s2 = 0;  // of fisheye models: k4, thin prism
  double omega = 0;                   // of FOV

  bool straight() const { return bend == Bend::None && polynomial_is_zero(); }
  bool polynomial_is_zero() const {
    return fourth == 0 && s1 == 0 && s2 == 0 && k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0 && k4 == 0 && k5 == 0 &&
           k6 == 0;
  }
};

Lens wide_lens_of(const ColmapCamera& camera) {
  const std::vector<double>& p = camera.params;
  Lens lens{};
  lens.bend = Bend::Fisheye;
  switch (camera.model_id) {
    case kSimpleRadialFisheye:
      lens.fx = lens.fy = p[0], lens.cx = p[1], lens.cy = p[2], lens.k1 = p[3];
      return lens;
    case kRadialFisheye:
      lens.fx = lens.fy = p[0], lens.cx = p[1], lens.cy = p[2], lens.k1 = p[3], lens.k2 = p[4];
      return lens;
    default:
      break;
  }
  if (p.size() >= 5) lens.fx = p[0], lens.fy = p[1], lens.cx = p[2], lens.cy = p[3];
  switch (camera.model_id) {
    case kOpenCvFisheye:
      lens.k1 = p[4], lens.k2 = p[5], lens.k3 = p[6], lens.fourth = p[7];
      return lens;
    case kThinPrismFisheye:
      lens.k1 = p[4], lens.k2 = p[5], lens.p1 = p[6], lens.p2 = p[7];
      lens.k3 = p[8], lens.fourth = p[9], lens.s1 = p[10], lens.s2 = p[11];
      return lens;
    case kFov:
      lens.bend = std::abs(p[4]) < kLeastOmega ? Bend::None : Bend::Fov, lens.omega = p[4];
      return lens;
    default:
      break;
  }
  const ColmapCameraType* type = colmap_camera_type(camera.model_id);
  if (type && type->name == "EQUIRECTANGULAR")
    throw Error(ErrorKind::Input, "the poses are of 360-degree panoramas",
                {.where = fmt::format("camera {}", camera.id),
                 .why = fmt::format("its model is EQUIRECTANGULAR ({} x {}): no pinhole camera shows all directions",
                                    camera.width, camera.height),
                 .hint = "cut the panoramas into pinhole views and give these photos with their poses: a perspective mode of "
                         "python/examples/panorama_sfm.py of COLMAP writes both",
                 .code = "CAMERA_MODEL_PANORAMA"});
  throw Error(ErrorKind::Input, "this camera model cannot be undistorted",
              {.where = fmt::format("camera {}", camera.id),
               .why = fmt::format("its model is {} (id {}); supported are the pinhole, radial, OPENCV, fisheye "
                                  "(up to THIN_PRISM_FISHEYE) and FOV models",
                                  type ? type->name : "unknown", camera.model_id),
               .hint = "undistort the model first: colmap image_undistorter --output_type COLMAP",
               .code = "CAMERA_MODEL_UNSUPPORTED"});
}

Lens lens_of(const ColmapCamera& camera) {
  const std::vector<double>& p = camera.params;
  switch (camera.model_id) {
    case kSimplePinhole:
      return {p[0], p[0], p[1], p[2]};
    case kPinhole:
      return {p[0], p[1], p[2], p[3]};
    case kSimpleRadial:
      return {p[0], p[0], p[1], p[2], p[3]};
    case kRadial:
      return {p[0], p[0], p[1], p[2], p[3], p[4]};
    case kOpenCv:
      return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]};
    case kFullOpenCv:
      return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11]};
    default:
      return wide_lens_of(camera);
  }
}

// Direction with the length that the lens gives it before the polynomial. `ray`: of any length; without a bend z > 0.
Vec2d bent(const Lens& lens, const Vec3d& ray) {
  if (lens.bend == Bend::None) return {ray.x / ray.z, ray.y / ray.z};
  const double r = std::hypot(ray.x, ray.y);
  if (r == 0) return {0, 0};
  const double to =
      lens.bend == Bend::Fisheye ? std::atan2(r, ray.z) : std::atan2(2 * r * std::tan(0.5 * lens.omega), ray.z) / lens.omega;
  return (to / r) * Vec2d{ray.x, ray.y};
}
// Inverse of bent(): a direction of any length; empty from 180 degrees on.
std::optional<Vec3d> straightened(const Lens& lens, const Vec2d& d) {
  const double r = std::hypot(d.x, d.y), angle = lens.bend == Bend::Fov ? r * lens.omega : r;
  if (lens.bend == Bend::None || r == 0) return Vec3d{d.x, d.y, 1};
  if (!(std::abs(angle) < std::numbers::pi)) return std::nullopt;
  const double across = lens.bend == Bend::Fisheye ? std::sin(angle) : std::sin(angle) / (2 * std::tan(0.5 * lens.omega));
  return Vec3d{across / r * d.x, across / r * d.y, std::cos(angle)};
}

// Distorted direction, and its Jacobian (row-major 2x2) if requested.
Vec2d distorted(const Lens& lens, const Vec2d& d, double* jacobian) {
  const double u = d.x, v = d.y, r2 = u * u + v * v;
  const double above = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * (lens.k3 + r2 * lens.fourth)));
  const double below = 1 + r2 * (lens.k4 + r2 * (lens.k5 + r2 * lens.k6));
  const double radial = above / below;
  if (jacobian) {
    const double above_slope = lens.k1 + r2 * (2 * lens.k2 + r2 * (3 * lens.k3 + r2 * 4 * lens.fourth));
    const double below_slope = lens.k4 + r2 * (2 * lens.k5 + r2 * 3 * lens.k6);
    const double slope = 2 * (above_slope - radial * below_slope) / below;  // d radial / d (r2 / 2)
    const double mixed = slope * u * v + 2 * lens.p1 * u + 2 * lens.p2 * v;
    jacobian[0] = radial + slope * u * u + 2 * lens.p1 * v + 6 * lens.p2 * u + 2 * lens.s1 * u;
    jacobian[1] = mixed + 2 * lens.s1 * v;
    jacobian[2] = mixed + 2 * lens.s2 * u;
    jacobian[3] = radial + slope * v * v + 2 * lens.p2 * u + 6 * lens.p1 * v + 2 * lens.s2 * v;
  }
  return {u * radial + 2 * lens.p1 * u * v + lens.p2 * (r2 + 2 * u * u) + lens.s1 * r2,
          v * radial + 2 * lens.p2 * u * v + lens.p1 * (r2 + 2 * v * v) + lens.s2 * r2};
}

}  // namespace

Vec2d project(const ColmapCamera& camera, const Vec2d& direction) { return project_ray(camera, {direction.x, direction.y, 1}); }

Vec2d project_ray(const ColmapCamera& camera, const Vec3d& ray) {
  const Lens lens = lens_of(camera);
  const Vec2d d = distorted(lens, bent(lens, ray), nullptr);
  return {lens.fx * d.x + lens.cx, lens.fy * d.y + lens.cy};
}

std::optional<Vec2d> unproject(const ColmapCamera& camera, const Vec2d& pixel) {
  const std::optional<Vec3d> ray = ray_of_pixel(camera, pixel);
  if (!ray || (is_fisheye(camera.model_id) && !(ray->z > std::cos(kWidestAngle) * length(*ray)))) return std::nullopt;
  return Vec2d{ray->x / ray->z, ray->y / ray->z};
}

std::optional<Vec3d> ray_of_pixel(const ColmapCamera& camera, const Vec2d& pixel) {
  const Lens lens = lens_of(camera);
  const Vec2d target{(pixel.x - lens.cx) / lens.fx, (pixel.y - lens.cy) / lens.fy};
  Vec2d d = target;
  if (lens.polynomial_is_zero()) return straightened(lens, d);
  // Newton's method from the undistorted direction: quadratic, 3 to 6 steps for real lenses.
  constexpr int kMaxSteps = 50;
  constexpr double kTolerance = 1e-12;
  for (int step = 0; step < kMaxSteps; ++step) {
    double j[4];
    const Vec2d miss = distorted(lens, d, j) - target;
    const double det = j[0] * j[3] - j[1] * j[2];
    // Beyond det = 0 the lens maps two directions to one pixel: not invertible.
    if (!(det > 0)) return std::nullopt;
    const Vec2d move{(j[3] * miss.x - j[1] * miss.y) / det, (j[0] * miss.y - j[2] * miss.x) / det};
    d = d - move;
    if (std::hypot(move.x, move.y) < kTolerance * (1 + std::hypot(d.x, d.y))) return straightened(lens, d);
  }
  return std::nullopt;
}

Intrinsics pinhole_part(const ColmapCamera& camera) {
  const Lens lens = lens_of(camera);
  return {static_cast<int>(camera.width), static_cast<int>(camera.height), lens.fx, lens.fy, lens.cx, lens.cy};
}

bool is_distorted(const ColmapCamera& camera) { return !lens_of(camera).straight(); }

ColmapCamera colmap_pinhole(uint32_t id, const Intrinsics& k) {
  return {id, kPinhole, static_cast<uint64_t>(k.width), static_cast<uint64_t>(k.height), {k.fx, k.fy, k.cx, k.cy}};
}

}  // namespace vitrine
