// Indexed triangle mesh. Faces are counter-clockwise seen from outside. Attributes are empty or have one value per vertex.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

struct TriMesh {
  std::vector<Vec3f> positions;                // [v]
  std::vector<Vec3f> normals;                  // [v] or empty, unit
  std::vector<Vec3f> colors;                   // [v] or empty, linear RGB
  std::vector<std::array<uint32_t, 3>> faces;  // [f]
  std::vector<uint16_t> object_ids = {};       // [v] or empty; ids of the object table (core/scene/objects), 0 = none

  // Object id shared by at least two corners of the face, else 0.
  uint16_t object_of_face(size_t f) const {
    if (object_ids.empty()) return 0;
    const uint16_t a = object_ids[faces[f][0]], b = object_ids[faces[f][1]], c = object_ids[faces[f][2]];
    return a == b || a == c ? a : b == c ? b : uint16_t(0);
  }
};

// Mesh statistics for mesh/report.json and the validity tests.
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
