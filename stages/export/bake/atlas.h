// Texture atlas of a triangle mesh. Charts are connected faces with similar normals, projected along their mean normal onto a
// plane (uniform texel size, stretched at most by 1 / cos(80 deg) on steep faces), rotated to their smallest rectangle and
// packed. Charts do not overlap, and a face that would overlap texels of its own chart starts a new chart.
//   texel (x, y) of a point p in chart c:  x = c.origin.x + s p.u,  y = c.origin.y - s p.up   (s = texels_per_unit, rows go down)
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

// `size`: texels per side; 0: a power of two in [256, 4096] with about four texels per mesh edge. Throws Error{Usage} if the
// charts do not fit at any scale.
Atlas make_atlas(const TriMesh& mesh, int size);

// Owning face and position of each covered texel, in row order.
struct AtlasTexel {
  uint32_t x, y, face;
  Vec3f barycentric;
};
std::vector<AtlasTexel> covered_texels(const Atlas& atlas, const TriMesh& mesh);

// Adjacent faces across each edge: [f][edge k joins corners k and k+1], kNoFace if there is none (or if more than two faces
// meet).
inline constexpr uint32_t kNoFace = 0xffffffffu;
std::vector<std::array<uint32_t, 3>> neighbour_faces(const TriMesh& mesh);

}  // namespace vitrine
