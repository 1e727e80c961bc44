// Marching cubes case table (Lorensen and Cline 1987), generated. A cell has 8 corners (bit 0: +x, bit 1: +y, bit 2: +z) and 12
// edges. On an ambiguous face (two opposite corners inside) the edge crossings can be joined in two ways; the caller chooses by
// the sign of the bilinear saddle point (asymptotic decider, Nielson and Hamann 1991). Both cells that share the face get the
// same answer, so the surface has no holes. Each crossing lies on exactly one loop of the cell. Loops are triangulated without
// diagonals inside a cell face, because the neighbour could have the same diagonal (an edge with four faces); where that is
// impossible a centre vertex is added.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace vitrine {

inline constexpr int kCellEdges = 12;
inline constexpr int kMaxCellLoops = 4;

// Edge e = 4 * axis + i joins corner edge_corner(e) to the corner one step along its axis.
constexpr int cell_edge(int axis, int side1, int side2) { return 4 * axis + side1 + 2 * side2; }
constexpr int cell_edge_axis(int edge) { return edge / 4; }
constexpr int cell_edge_corner(int edge) {
  const int axis = edge / 4;
  return ((edge & 1) << ((axis + 1) % 3)) | (((edge >> 1) & 1) << ((axis + 2) % 3));
}

// Corners of face f = 2 * axis + side, counter-clockwise seen from outside the cell.
const std::array<int, 4>& cell_face_corners(int face);
// Bit f: face f has two opposite corners inside and two outside.
uint8_t ambiguous_faces(uint8_t inside_corners);

struct CellCase {
  // Vertices 0-11 are edge crossings; 12 + l is the mean of loop l. Counter-clockwise seen from outside the surface.
  std::vector<std::array<uint8_t, 3>> triangles;
  std::vector<std::vector<uint8_t>> centred_loops;  // crossings of loop l, which has centre vertex 12 + l
};
// `joined`, bit f: the inside corners of ambiguous face f are connected across the face.
const CellCase& cell_case(uint8_t inside_corners, uint8_t joined);

}  // namespace vitrine
