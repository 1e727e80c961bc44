// Zero level set of a function that is linear in every tetrahedron (marching tetrahedra, Doi and Koide 1991). Tetrahedra that
// share whole faces give a manifold whose faces have the positive side in front: closed unless a face on the hull changes sign.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct Tetrahedra {
  std::vector<Vec3d> positions;                // [v]
  std::vector<double> values;                  // [v] below 0: inside
  std::vector<std::array<uint32_t, 4>> cells;  // [c] positively oriented: dot(b - a, cross(c - a, d - a)) > 0
};

// Crossings are at least kLeastCrossing of an edge away from its ends: no two vertices of the result coincide, and no face has a
// repeated corner. The result does not depend on the order of the cells and of their corners.
inline constexpr double kLeastCrossing = 0.02;
TriMesh zero_level(const Tetrahedra& tetrahedra);

}  // namespace vitrine
