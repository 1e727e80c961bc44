// Repair of a triangle soup into an oriented manifold mesh without self-intersections, by CGAL. CGAL is GPL-3.0-or-later: only
// vitrine-mesh links the library of this header, vitrine_repair_cgal.
#pragma once

#include <cstddef>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct RepairDesc {
  size_t max_hole_edges = 64;   // holes with at most this many boundary edges are filled; 0 = none
  int intersection_rounds = 3;  // maximum rounds of removing intersecting faces and filling the gap
};

struct RepairReport {
  size_t duplicate_vertices = 0;  // merged, same position
  size_t dropped_faces = 0;       // degenerate or duplicate
  size_t flipped_components = 0;  // flipped to match the vertex normals, or to face away from the centre of the component
  size_t intersecting_faces = 0;  // removed
  size_t filled_holes = 0, filled_faces = 0;
};

// Vertex positions and colours are unchanged; normals are dropped (call vertex_normals() afterwards). Input normals, if
// present, determine the orientation; without them faces point away from the centre of their component.
TriMesh repaired(const TriMesh& mesh, const RepairDesc& desc, RepairReport* report = nullptr);

// Number of face pairs that cross or overlap. Neighbours that only share an edge or a vertex do not count.
size_t self_intersection_count(const TriMesh& mesh);

}  // namespace vitrine
