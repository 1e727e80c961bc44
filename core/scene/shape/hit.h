// Rays, hits, points and parameters: types shared by all shapes (shape.h).
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/foundation/math/rigid.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

struct Ray {
  Vec3d origin, direction;  // of any non-zero length
};

// Ray hit on a shape.
struct ShapeHit {
  double t = 0;          // in units of the ray direction's length, > 0
  Vec3d normal{};        // unit, facing the ray origin except where smooth shading tilts it at grazing angles
  uint32_t element = 0;  // face of a box or mesh, side of a plane, segment of a profile
  Vec2d at{};            // position in the element: along the segment, or barycentric weights of the second and third corner
};
// dL/dt and dL/dnormal.
struct ShapeHitGrad {
  double t = 0;
  Vec3d normal{};
};

struct ShapePoint {
  Vec3d position, normal;  // on the surface; normal is unit, outwards
};

// Parameters optimised together with one second moment. They are increments: 0 leaves the shape unchanged.
enum class ParameterUnit : unsigned char { Length, Angle };
struct ParameterGroup {
  size_t count = 0;
  ParameterUnit unit = ParameterUnit::Length;
  double scale = 1;  // step size relative to other groups of the unit
};

// Plane of a flat face: dot(normal, p) = offset.
struct Facet {
  Vec3d normal;
  double offset;
};

// Rotation of a frame by a rotation vector: direction = axis, length = angle (Rodrigues' formula as a unit quaternion).
inline constexpr double kLeastExtent_rel = 0.1;  // minimum fraction of a side left after one descent step

inline Mat3d turned_by(const Vec3d& turn, const Mat3d& axes) {
  const double angle = length(turn);
  if (!(angle > 0)) return axes;
  const Vec3d v = std::sin(0.5 * angle) / angle * turn;
  return rotation_matrix(normalized(Quatd{std::cos(0.5 * angle), v.x, v.y, v.z})) * axes;
}

}  // namespace vitrine
