// Mesh statistics for mesh/report.json and the validity tests.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct MeshReport {
  size_t vertices = 0, faces = 0, edges = 0;
  size_t manifold_edges = 0;     // exactly two faces, with opposite directions along the edge
  size_t boundary_edges = 0;     // one face
  size_t nonmanifold_edges = 0;  // all others
  size_t boundary_loops = 0;     // connected sets of boundary edges
  size_t components = 0;         // faces connected through edges
  size_t largest_component = 0;  // number of faces
  size_t degenerate_faces = 0;   // repeated vertex or zero area
  size_t loose_vertices = 0;     // used by no face
  int64_t euler = 0;             // used vertices - edges + faces
  double area = 0;
  double volume = 0;  // signed sum of tetrahedra; valid for closed meshes only
  Bounds3 bounds;     // of the used vertices
  bool closed() const { return faces > 0 && boundary_edges == 0 && nonmanifold_edges == 0; }
};

MeshReport mesh_report(const TriMesh& mesh);

}  // namespace vitrine
