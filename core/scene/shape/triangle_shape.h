// Triangle mesh with smooth normals, closed or open: the fallback where no simple shape fits. Rays hit front faces only.
// Parameters: displacement of each vertex along its normal.
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
  // Computes the normals. Throws Error{Input} if a face refers to a missing vertex; the mesh must have a face.
  explicit TriangleShape(TriMesh mesh);

  const TriMesh& mesh() const;  // with normals

  // First hit, if it is a front face. The normal is interpolated.
  std::optional<ShapeHit> intersect(const Ray& ray) const;
  ShapePoint nearest(const Vec3d& p) const;
  std::vector<Vec3d> outer_points() const;
  TriMesh tessellated(double) const { return mesh(); }
  double size() const;
  std::vector<Facet> facets() const { return {}; }

  std::vector<ParameterGroup> parameters() const;
  // First-order: ignores the derivative of the face weights in the vertex normals.
  void hit_vjp(const Ray& ray, const ShapeHit& hit, const ShapeHitGrad& grad, std::span<double> out) const;
  void place_vjp(const ShapeHit& hit, const Vec3d& place, const Vec3d& grad, std::span<double> out) const;
  void smooth(std::span<double> grad) const;  // averages over neighbours: unobserved vertices follow observed ones
  TriangleShape moved(std::span<const double> step) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;  // immutable, shared by copies
};

}  // namespace vitrine
