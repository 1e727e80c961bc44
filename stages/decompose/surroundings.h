// Surroundings of the mesh as a shell of triangles that blocks and reflects light. The mesh covers only the region that the
// cameras face; the walls of the room are surfels. Rays from the centre of the mesh through the diffuse layer, from the faces of
// the mesh's box, give a panorama of distances and radiances, which is triangulated. Directions without a surface, or with none
// nearer than `sky_distance`, are open: light arrives from there.
#pragma once

#include <span>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

struct SurroundingsDesc {
  Bounds3 inner;             // the mesh's box; its content is ignored
  int height = 64;           // rows of the panorama, twice as many columns
  float min_alpha = 0.5f;    // directions with less are open
  float sky_distance = 4.f;  // scene units from the centre: farther content is light, not a wall
};

struct Surroundings {
  Vec3f centre{};
  int height = 0;
  // [height * 2 height], rows from +z to -z at equal angles, columns as in an environment (core/scene/light).
  std::vector<float> distance;  // 0: no surface
  std::vector<Vec3f> radiance;  // of the wall, or of the sky where surfels show it
  std::vector<bool> wall;       // nearer than the sky

  size_t texel_of(const Vec3f& unit_direction) const;
  Vec3f direction(size_t texel) const;
  bool seen(size_t texel) const { return distance[texel] > 0; }
  // Vertices are texels with a wall, coloured by their radiance; faces are oriented to the centre.
  TriMesh shell() const;
  double wall_share() const;  // of the sphere
};

// Distance from the centre of the mesh's box beyond which content is sky: clearly beyond all triangulated points. The largest
// float without a triangulated point.
float distance_to_sky(std::span<const Vec3f> triangulated, const Bounds3& inner);

Surroundings surroundings(const SplatLayer& diffuse, const SurroundingsDesc& desc);

}  // namespace vitrine
