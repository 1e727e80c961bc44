// Repair of a triangle soup into an oriented manifold mesh without self-intersections, by CGAL (GPL-3.0-or-later: this header's
// library, vitrine_repair_cgal, is linked by vitrine-mesh alone).
#pragma once

#include <cstddef>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct RepairDesc {
  size_t max_hole_edges = 64;   // boundaries of at most so many edges are closed; 0 = none
  int intersection_rounds = 3;  // remove intersecting faces and close the gap, at most so often
};

struct RepairReport {
  size_t duplicate_vertices = 0;  // merged: same position
  size_t dropped_faces = 0;       // degenerate or duplicate
  size_t flipped_components = 0;  // turned to agree with the vertex normals, or to look away from their centre
  size_t intersecting_faces = 0;  // removed
  size_t filled_holes = 0, filled_faces = 0;
};

// Vertices keep position and colour exactly; normals are dropped (compute vertex_normals() afterwards). Input normals, when
// present, decide which side is outside; without them faces look away from the centre of their component.
TriMesh repaired(const TriMesh& mesh, const RepairDesc& desc, RepairReport* report = nullptr);

// Pairs of faces that cross or overlap (neighbours that merely share an edge or a vertex do not count).
size_t self_intersection_count(const TriMesh& mesh);

}  // namespace vitrine
