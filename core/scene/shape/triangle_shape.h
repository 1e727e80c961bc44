// A triangle mesh with smooth normals, closed or open: what no simple shape is. Rays meet the fronts of its faces. Parameters:
// each vertex along its normal.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/hit.h"

namespace vitrine {

class TriangleShape {
 public:
  // Normals are computed. Throws Error{Input} when a face names a vertex that does not exist; there must be a face.
  explicit TriangleShape(TriMesh mesh);

  const TriMesh& mesh() const;  // with normals

  // Where a ray first meets it, if that is the front of a face. The normal is interpolated.
  std::optional<ShapeHit> intersect(const Ray& ray) const;
  ShapePoint nearest(const Vec3d& p) const;
  std::vector<Vec3d> outer_points() const;
  TriMesh tessellated(double) const { return mesh(); }
  double size() const;
  std::vector<Facet> facets() const { return {}; }

  std::vector<ParameterGroup> parameters() const;
  // To first order: how the weights of faces in the normals of vertices change counts for nothing.
  void hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const;
  void place_vjp(const ShapeHit& hit, const Vec3d& place, const Vec3d& grad, std::span<double> out) const;
  void smooth(std::span<double> grad) const;  // neighbours move alike: what no photo looks at follows
  TriangleShape moved(std::span<const double> step) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;  // never changes: copies share it
};

}  // namespace vitrine
