// Rectangle in any position: a pane, a mirror on a wall, a table top. Two-sided: the normal faces the ray origin. Parameters:
// rotation about the centre (3, radians), shift of the centre (3), half sizes (2).
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/hit.h"

namespace vitrine {

struct Plane {
  Vec3d centre;
  Mat3d axes;    // columns: two side directions and the front normal; orthonormal, right-handed
  Vec2d half{};  // half sizes along the first two axes

  std::optional<ShapeHit> intersect(const Ray& ray) const;  // element 0: hit from the front; 1: from behind
  ShapePoint nearest(const Vec3d& p) const;                 // normal of the side that faces p
  std::vector<Vec3d> outer_points() const;
  TriMesh tessellated(double) const;  // front side, exact
  double size() const { return 2 * std::max(half.x, half.y); }
  std::vector<Facet> facets() const { return {{axes.c2, dot(axes.c2, centre)}, {-axes.c2, -dot(axes.c2, centre)}}; }

  std::vector<ParameterGroup> parameters() const;
  void hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const;
  void place_vjp(const ShapeHit& hit, const Vec3d& place, const Vec3d& grad, std::span<double> out) const;
  void smooth(std::span<double>) const {}
  Plane moved(std::span<const double> step) const;
};

}  // namespace vitrine
