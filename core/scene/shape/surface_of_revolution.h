// A profile curve turned about an axis (vases, bottles, bowls, lathe work): a polyline in the half plane of the axis, so that it
// may run level, as lids and feet do. Normals are smooth: those of the vertices of the profile, blended along its segments
// (algorithms 9.4). Parameters: shift of the origin along two directions across the axis (2), tilt of the axis towards them (2,
// radians), each vertex of the profile along its normal (of one on the axis: along the axis).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/hit.h"

namespace vitrine {

struct SurfaceOfRevolution {
  Vec3d origin, axis;          // a point of the axis, its unit direction
  std::vector<Vec2d> profile;  // vertices (radius, height above `origin`), from the bottom to the top; the solid is inside

  double largest_radius() const;
  // Outwards, of unit length, of the segment between vertices i and i + 1; and at the vertices, their sums (not of unit length).
  Vec2d segment_normal(size_t i) const;
  Vec2d vertex_normal(size_t i) const;

  // Where a ray from outside goes in first. `at`: x, how far along the segment `element`.
  std::optional<ShapeHit> intersect(const Ray& ray) const;
  ShapePoint nearest(const Vec3d& p) const;
  std::vector<Vec3d> outer_points() const;
  TriMesh tessellated(double spacing) const;  // rings at the vertices of the profile, corners `spacing` apart or less
  double size() const { return largest_radius(); }
  std::vector<Facet> facets() const { return {}; }

  std::vector<ParameterGroup> parameters() const;
  void hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const;
  void place_vjp(const ShapeHit& hit, const Vec3d& place, const Vec3d& grad, std::span<double> out) const;
  void smooth(std::span<double> grad) const;  // a profile bends slowly
  SurfaceOfRevolution moved(std::span<const double> step) const;

 private:
  Vec2d way(size_t vertex) const;  // where its parameter moves it
};

// The same curve with `count` segments of equal length.
SurfaceOfRevolution with_equal_segments(const SurfaceOfRevolution& surface, size_t count);

}  // namespace vitrine
