// Oriented box with ray entry and exit. Parameters: rotation about the centre (3, radians), lower ends of the extent along its
// axes (3), upper ends (3).
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/hit.h"

namespace vitrine {

struct Box {
  // Face at the lower or upper end of the extent along an axis.
  struct Face {
    size_t axis = 0;
    bool upper = false;
    size_t index() const { return 2 * axis + (upper ? 1 : 0); }
    bool operator==(const Face&) const = default;
  };
  static constexpr size_t kFaces = 6;
  static Face face(size_t index) { return {index / 2, index % 2 == 1}; }

  Mat3d axes;       // columns: unit vectors along the edges, right-handed
  Vec3d low, high;  // extent along the axes: p is inside if low <= transposed(axes) p <= high

  // Bit k of i: upper end along axis k.
  Vec3d corner(size_t i) const { return axes * Vec3d{i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z}; }
  Vec3d centre() const { return axes * (0.5 * (low + high)); }
  Vec3d normal(Face f) const {  // outwards
    Vec3d n{};
    n[f.axis] = f.upper ? 1 : -1;
    return axes * n;
  }
  double offset(Face f) const { return f.upper ? high[f.axis] : -low[f.axis]; }  // dot(normal, p) of points on the face
  double longest_side() const { return std::max({high.x - low.x, high.y - low.y, high.z - low.z}); }

  // Signed distance to the surface, negative inside.
  double distance(const Vec3d& p) const;

  struct Crossing {
    double in, out;  // ray parameters, in units of the direction's length
    Face entered, left;
  };
  // For a ray that starts outside.
  std::optional<Crossing> crossing(const Vec3d& origin, const Vec3d& direction) const;

  std::optional<ShapeHit> intersect(const Ray& ray) const;  // element: Face::index of the entry face
  ShapePoint nearest(const Vec3d& p) const;
  std::vector<Vec3d> outer_points() const;
  TriMesh tessellated(double) const;  // exact
  double size() const { return longest_side(); }
  std::vector<Facet> facets() const;  // [Face::index]

  std::vector<ParameterGroup> parameters() const;
  void hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const;
  void place_vjp(const ShapeHit& hit, const Vec3d& place, const Vec3d& grad, std::span<double> out) const;
  void smooth(std::span<double>) const {}
  Box moved(std::span<const double> step) const;
};

}  // namespace vitrine
