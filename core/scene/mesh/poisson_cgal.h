// Closed surface through oriented points: Poisson surface reconstruction (Kazhdan, Bolitho and Hoppe 2006) on a Delaunay
// triangulation refined around the points, by CGAL (Alliez, Saboret and Guennebaud). CGAL is GPL-3.0-or-later: only vitrine-mesh
// links the library of this header, vitrine_repair_cgal.
#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

inline constexpr size_t kLeastPoissonPoints = 100;

struct PoissonReport {
  size_t points = 0;      // of the input, finite and with a normal
  size_t vertices = 0;    // of the triangulation, with those of its refinement
  size_t cut_points = 0;  // added on the box around the points, where the solid would go on beyond it
  bool inwards = false;   // the normals point into the closed volume, as those of a room seen from inside do
};

// Every edge of the result has two faces, whose normals point to the side of `normals`. What lies behind the points is solid; the
// solid ends at the box around them, grown by a twentieth of its diagonal: a table that nobody saw from below becomes a plinth.
// Points of a closed room seen from inside enclose its air instead, with a negative volume. The level is the median of the
// indicator function at the points, which weigh the same: they should be spread evenly. Points without a finite position or a
// normal are left out. No attributes; sequential: the result does not depend on the number of threads. `progress` receives a
// fraction every thousand points; it may throw to interrupt. Throws Error{Input} with code NOT_CLOSED for fewer than
// kLeastPoissonPoints points and where there is no closed surface, Error{Usage} for spans of different length.
TriMesh poisson_surface(std::span<const Vec3f> points, std::span<const Vec3f> normals, PoissonReport* report = nullptr,
                        const std::function<void(double)>& progress = {});

}  // namespace vitrine
