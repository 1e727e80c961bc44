// Projection with the supported COLMAP camera models. With (u, v) the ideal direction and r2 = u^2 + v^2:
//   SIMPLE_RADIAL, RADIAL:  d = (k1 r2 + k2 r2^2) (u, v)
//   OPENCV:                 d = (k1 r2 + k2 r2^2) (u, v) + (2 p1 u v + p2 (r2 + 2 u^2), 2 p2 u v + p1 (r2 + 2 v^2))
//   FULL_OPENCV:            OPENCV with the radial factor (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
//   pixel = f (u + d_u, v + d_v) + c
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/scene/camera/colmap_model.h"

namespace vitrine {

namespace {

enum Model { kSimplePinhole = 0, kPinhole = 1, kSimpleRadial = 2, kRadial = 3, kOpenCv = 4, kFullOpenCv = 6 };

struct Lens {
  double fx, fy, cx, cy;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  double k3 = 0, k4 = 0, k5 = 0, k6 = 0;

  bool straight() const { return k1 == 0 && k2 == 0 && p1 == 0 && p2 == 0 && k3 == 0 && k4 == 0 && k5 == 0 && k6 == 0; }
};

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
  throw Error(
      ErrorKind::Input, "this camera model cannot be undistorted",
      {.where = fmt::format("camera {}", camera.id),
       .why = fmt::format("its model is {} (id {}); supported are SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV and "
                          "FULL_OPENCV",
                          type ? type->name : "unknown", camera.model_id),
       .hint = "undistort the model first: colmap image_undistorter --output_type COLMAP",
       .code = "CAMERA_MODEL_UNSUPPORTED"});
}

// Distorted direction, and its Jacobian (row-major 2x2) if requested.
Vec2d distorted(const Lens& lens, const Vec2d& d, double* jacobian) {
  const double u = d.x, v = d.y, r2 = u * u + v * v;
  const double above = 1 + r2 * (lens.k1 + r2 * (lens.k2 + r2 * lens.k3));
  const double below = 1 + r2 * (lens.k4 + r2 * (lens.k5 + r2 * lens.k6));
  const double radial = above / below;
  if (jacobian) {
    const double above_slope = lens.k1 + r2 * (2 * lens.k2 + r2 * 3 * lens.k3);
    const double below_slope = lens.k4 + r2 * (2 * lens.k5 + r2 * 3 * lens.k6);
    const double slope = 2 * (above_slope - radial * below_slope) / below;  // d radial / d (r2 / 2)
    jacobian[0] = radial + slope * u * u + 2 * lens.p1 * v + 6 * lens.p2 * u;
    jacobian[1] = slope * u * v + 2 * lens.p1 * u + 2 * lens.p2 * v;
    jacobian[2] = jacobian[1];
    jacobian[3] = radial + slope * v * v + 2 * lens.p2 * u + 6 * lens.p1 * v;
  }
  return {u * radial + 2 * lens.p1 * u * v + lens.p2 * (r2 + 2 * u * u),
          v * radial + 2 * lens.p2 * u * v + lens.p1 * (r2 + 2 * v * v)};
}

}  // namespace

Vec2d project(const ColmapCamera& camera, const Vec2d& direction) {
  const Lens lens = lens_of(camera);
  const Vec2d d = distorted(lens, direction, nullptr);
  return {lens.fx * d.x + lens.cx, lens.fy * d.y + lens.cy};
}

std::optional<Vec2d> unproject(const ColmapCamera& camera, const Vec2d& pixel) {
  const Lens lens = lens_of(camera);
  const Vec2d target{(pixel.x - lens.cx) / lens.fx, (pixel.y - lens.cy) / lens.fy};
  Vec2d d = target;
  if (lens.straight()) return d;
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
    if (std::hypot(move.x, move.y) < kTolerance * (1 + std::hypot(d.x, d.y))) return d;
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
