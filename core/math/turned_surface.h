// A surface that is turned on a lathe (vase, bottle, bowl): a curve in the half plane of an axis, as a line through
// corners. Unlike a list of radii it may run level, as lids and feet do.
#pragma once

#include <optional>
#include <vector>

#include "core/math/rigid.h"

namespace vitrine {

struct TurnedSurface {
  Vec3d origin, axis;          // a point of the axis, its unit direction
  std::vector<Vec2d> profile;  // corners (radius, height above `origin`), from the bottom to the top; the solid is inside

  double largest_radius() const;
  // Outwards, of unit length, of the line between corners i and i + 1; and at the corners, their sums (not of unit length).
  std::vector<Vec2d> line_normals() const;
  std::vector<Vec2d> corner_normals() const;

  struct Entry {
    double t;     // along the ray, in units of its direction
    size_t line;  // between profile[line] and profile[line + 1]
  };
  // Where a ray from outside goes in first.
  std::optional<Entry> entry(const Vec3d& eye, const Vec3d& direction) const;

  struct Place {
    Vec3d position, normal;  // of the surface; outwards, unit
  };
  // The nearest to `p`, with the normals of the corners blended between them.
  Place nearest(const Vec3d& p) const;
};

// What is asked of a turned surface. The axis' part along the axis means nothing.
struct TurnedGradient {
  Vec3d origin{}, axis{};
  std::vector<Vec2d> profile;  // [corner]
};

// From a gradient on the corner normals to one on the corners, added.
void corner_normals_vjp(const TurnedSurface& surface, const std::vector<Vec2d>& grad_normals, std::vector<Vec2d>& grad_profile);

// The same curve with `count` lines of equal length.
TurnedSurface with_equal_lines(const TurnedSurface& surface, size_t count);

}  // namespace vitrine
