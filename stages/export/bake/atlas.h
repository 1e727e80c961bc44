// A texture atlas of a triangle mesh: charts are connected groups of faces that look roughly the same way, each projected
// along its mean normal onto a plane (so texels have one size, stretched at most by 1 / cos(80 deg) where a face is steep),
// turned to their smallest rectangle and packed. No two charts overlap, and within a chart a face that would land on
// texels that are taken starts a chart of its own.
//   texel (x, y) of a point p of chart c:  x = c.origin.x + s p.u,  y = c.origin.y - s p.up   (s = texels_per_unit, rows go down)
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct AtlasChart {
  Vec3f u, up, normal;  // orthonormal, right-handed: u x up = normal
  Vec2f origin{};       // texels
  int x = 0, y = 0;     // its rectangle in the atlas, padding included
  int width = 0, height = 0;
};

struct Atlas {
  int size = 0;
  float texels_per_unit = 0;
  std::vector<AtlasChart> charts;
  std::vector<uint32_t> chart_of_face;  // [f]

  Vec2f texel(uint32_t chart, const Vec3f& p) const {
    const AtlasChart& c = charts[chart];
    return {c.origin.x + texels_per_unit * dot(p, c.u), c.origin.y - texels_per_unit * dot(p, c.up)};
  }
};

// `size`: texels on each side; 0: so that an edge of the mesh gets four texels, a power of two in [256, 4096]. Throws
// Error{Usage} when the charts do not fit, however small.
Atlas make_atlas(const TriMesh& mesh, int size);

// Which face owns each texel, and where in it: texels in order of rows.
struct AtlasTexel {
  uint32_t x, y, face;
  Vec3f barycentric;
};
std::vector<AtlasTexel> covered_texels(const Atlas& atlas, const TriMesh& mesh);

// Faces on either side of each edge of each face: [f][edge k joins corners k and k+1], kNoFace where there is none (or where
// more than two faces meet).
inline constexpr uint32_t kNoFace = 0xffffffffu;
std::vector<std::array<uint32_t, 3>> neighbour_faces(const TriMesh& mesh);

}  // namespace vitrine
