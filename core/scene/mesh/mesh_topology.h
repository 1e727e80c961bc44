// Mesh connectivity: edges with their faces, connected components, submeshes, vertex normals.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

// One side of one face. Sorting by (low, high) groups the faces of an edge.
struct EdgeUse {
  uint32_t low, high;  // vertices, low < high
  uint32_t face;
  bool forward;  // the face runs from low to high
  bool operator<(const EdgeUse& o) const {
    return low != o.low ? low < o.low : high != o.high ? high < o.high : face != o.face ? face < o.face : forward < o.forward;
  }
};
// Skips degenerate sides (both ends the same vertex).
std::vector<EdgeUse> sorted_edge_uses(const TriMesh& mesh);

// Calls body(first, last) for every edge with the index range of its uses.
template <class Body>
void for_each_edge(std::span<const EdgeUse> uses, Body&& body) {
  for (size_t i = 0; i < uses.size();) {
    size_t j = i + 1;
    while (j < uses.size() && uses[j].low == uses[i].low && uses[j].high == uses[i].high) ++j;
    body(i, j);
    i = j;
  }
}

// Connected components of faces that share edges, numbered by their first face.
struct FaceComponents {
  std::vector<uint32_t> label;  // [f]
  std::vector<size_t> faces;    // [components] number of faces
};
FaceComponents face_components(const TriMesh& mesh);

// Faces with keep[f] != 0 and the vertices they use, in the original order.
TriMesh submesh(const TriMesh& mesh, std::span<const uint8_t> keep);

// Vertices that share an edge with a vertex, ascending.
struct VertexNeighbours {
  explicit VertexNeighbours(const TriMesh& mesh);
  std::span<const uint32_t> of(size_t v) const { return std::span(vertex).subspan(first[v], first[v + 1] - first[v]); }

  std::vector<uint32_t> first, vertex;  // [v + 1] offsets; neighbours of all vertices
};

// Mean of the unit face normals around a vertex, weighted by the corner angles (Thuermer and Wuethrich 1998): independent of
// the triangulation. (0,0,1) where the area is 0.
std::vector<Vec3f> vertex_normals(const TriMesh& mesh);

}  // namespace vitrine
