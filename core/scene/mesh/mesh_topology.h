// How the faces of a mesh hang together: edges with their faces, connected components, and moving to a subset of the faces.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

// One side of one face. Sorted by (low, high), the faces of an edge stand together.
struct EdgeUse {
  uint32_t low, high;  // vertices, low < high
  uint32_t face;
  bool forward;  // the face runs from low to high
  bool operator<(const EdgeUse& o) const {
    return low != o.low ? low < o.low : high != o.high ? high < o.high : face != o.face ? face < o.face : forward < o.forward;
  }
};
// Sides that join a vertex to itself are left out.
std::vector<EdgeUse> sorted_edge_uses(const TriMesh& mesh);

// Calls body(first, last) for every edge, with the range of its uses.
template <class Body>
void for_each_edge(std::span<const EdgeUse> uses, Body&& body) {
  for (size_t i = 0; i < uses.size();) {
    size_t j = i + 1;
    while (j < uses.size() && uses[j].low == uses[i].low && uses[j].high == uses[i].high) ++j;
    body(i, j);
    i = j;
  }
}

// Components: faces that share an edge belong together. Numbered in the order of their first face.
struct FaceComponents {
  std::vector<uint32_t> label;  // [f]
  std::vector<size_t> faces;    // [components] number of faces
};
FaceComponents face_components(const TriMesh& mesh);

// The faces with keep[f] != 0 and the vertices they use, in the old order.
TriMesh submesh(const TriMesh& mesh, std::span<const uint8_t> keep);

// The vertices that share an edge with one, ascending.
struct VertexNeighbours {
  explicit VertexNeighbours(const TriMesh& mesh);
  std::span<const uint32_t> of(size_t v) const { return std::span(vertex).subspan(first[v], first[v + 1] - first[v]); }

  std::vector<uint32_t> first, vertex;  // [v + 1], those of v
};

// Mean of the unit face normals around a vertex, weighted by the corner angles (Thuermer and Wuethrich 1998): not misled by how
// the surface happens to be cut into triangles. (0,0,1) where there is no area.
std::vector<Vec3f> vertex_normals(const TriMesh& mesh);

}  // namespace vitrine
