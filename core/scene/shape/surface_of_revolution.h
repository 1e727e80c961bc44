// Surface of revolution: a profile curve rotated about an axis (vases, bottles, bowls, lathe work). The profile is a polyline
// in the half plane of the axis, so it may have horizontal parts (lids, feet). Normals are smooth: profile vertex normals
// interpolated along the segments (algorithms 9.4). Parameters: shift of the origin along two directions across the axis (2),
// tilt of the axis towards them (2, radians), displacement of each profile vertex along its normal (vertices on the axis: along
// the axis).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/hit.h"

namespace vitrine {

struct SurfaceOfRevolution {
  Vec3d origin, axis;          // point on the axis, unit direction
  std::vector<Vec2d> profile;  // vertices (radius, height above `origin`), bottom to top; the solid is on the inner side

  double largest_radius() const;
  // Outward normals: of the segment between vertices i and i + 1 (unit); of the vertices, sums of them (not unit).
  Vec2d segment_normal(size_t i) const;
  Vec2d vertex_normal(size_t i) const;

  // First entry of a ray that starts outside. `at.x`: position along the segment `element`.
  std::optional<ShapeHit> intersect(const Ray& ray) const;
  ShapePoint nearest(const Vec3d& p) const;
  std::vector<Vec3d> outer_points() const;
  TriMesh tessellated(double spacing) const;  // rings at the profile vertices, corners at most `spacing` apart
  double size() const { return largest_radius(); }
  std::vector<Facet> facets() const { return {}; }

  std::vector<ParameterGroup> parameters() const;
  void hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const;
  void place_vjp(const ShapeHit& hit, const Vec3d& place, const Vec3d& grad, std::span<double> out) const;
  void smooth(std::span<double> grad) const;  // keeps the profile smooth
  SurfaceOfRevolution moved(std::span<const double> step) const;

 private:
  Vec2d way(size_t vertex) const;  // direction in which the vertex parameter moves it
};

// Same curve resampled to `count` segments of equal length.
SurfaceOfRevolution with_equal_segments(const SurfaceOfRevolution& surface, size_t count);

}  // namespace vitrine
