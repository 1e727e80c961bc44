// A scene under a similarity x -> s R x + t: surfels, meshes, known shapes. Under the identity every value keeps its bytes.
//
// Surfels: positions by the similarity, quaternions by R, log scales by log s. Radiance is a function of the direction in the
// world, L'(d) = L(R^T d): the coefficients of each degree are multiplied by the matrix  M_ij = integral Y_i(d) Y_j(R^T d) dd.
// The integrand is a polynomial of degree 6 at most, which a product of a Gauss-Legendre rule of four nodes and a uniform rule of
// eight azimuths integrates exactly (Atkinson and Han, "Spherical Harmonics and Approximations on the Unit Sphere", 2012, 5.2).
#pragma once

#include <array>

#include "core/foundation/math/rigid.h"
#include "core/render/edit/edit_scene.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/shape_set.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Rotation of real spherical harmonics of degree 3 at most, in the order of core/foundation/math/spherical_harmonics.h.
class ShRotation {
 public:
  explicit ShRotation(const Mat3d& rotation);
  // `rest`: coefficients of degree 1 to `degree`, [k - 1][rgb]; changed in place. That of degree 0 does not change.
  void apply(int degree, float* rest) const;

 private:
  std::array<std::array<double, 16>, 16> matrix_{};  // [i][j], zero between degrees
};

SplatLayer placed(SplatLayer layer, const Similarity& place);
TriMesh placed(TriMesh mesh, const Similarity& place);  // positions and normals
Shape placed(const Shape& shape, const Similarity& place);
ShapeSet placed(ShapeSet set, const Similarity& place);  // also the tolerances, which are lengths

// Surfels of all layers, meshes, known shapes, solid glass; of the materials, mean free paths and directions of brush marks.
EditScene placed(EditScene scene, const Similarity& place);

}  // namespace vitrine
