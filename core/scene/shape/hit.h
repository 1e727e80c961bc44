// What all kinds of shapes (shape.h) say of rays, points and parameters, in the same words.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/foundation/math/vec.h"

namespace vitrine {

struct Ray {
  Vec3d origin, direction;  // of any length but 0
};

// Where a ray meets a shape.
struct ShapeHit {
  double t = 0;          // in units of the ray's direction, > 0
  Vec3d normal{};        // unit, against the ray but for what smooth shading turns at grazing angles
  uint32_t element = 0;  // face of a box or a mesh, side of a plane, segment of a profile
  Vec2d at{};            // place in it: along the segment; weights of the second and third corner of the face
};
// dL/dt and dL/dnormal.
struct ShapeHitGrad {
  double t = 0;
  Vec3d normal{};
};

struct ShapePoint {
  Vec3d position, normal;  // of the surface; unit, outwards
};

// Parameters that descend together, with one second moment. A step moves the shape by itself: by 0 it stays as it is.
enum class ParameterUnit : unsigned char { Length, Angle };
struct ParameterGroup {
  size_t count = 0;
  ParameterUnit unit = ParameterUnit::Length;
  double scale = 1;  // of its steps, to those of other groups of the unit
};

// Where a box or a rectangle is flat: dot(normal, p) = offset.
struct Facet {
  Vec3d normal;
  double offset;
};

}  // namespace vitrine
