// What stands around the mesh: a mesh covers the place that the cameras look at, the walls of the room behind it are surfels
// only. Seen from the centre of the mesh they are a panorama of distances and radiances (rays through the diffuse layer, from
// where they leave the box of the mesh), and the panorama is a shell of triangles: it blocks light, and it reflects light.
// Directions in which nothing stands, or nothing nearer than `sky_distance`, stay open: light comes from there.
#pragma once

#include <span>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

struct SurroundingsDesc {
  Bounds3 inner;             // the mesh's box; what is in it is the mesh's business
  int height = 64;           // rows of the panorama, twice as many columns
  float min_alpha = 0.5f;    // less is open
  float sky_distance = 4.f;  // scene units from the centre: what is farther counts as light, not as a wall
};

struct Surroundings {
  Vec3f centre{};
  int height = 0;
  // [height * 2 height], rows from +z to -z at equal angles, columns as those of an environment (core/scene/light).
  std::vector<float> distance;  // 0: nothing there
  std::vector<Vec3f> radiance;  // of the wall, or of the sky where surfels show it
  std::vector<bool> wall;       // nearer than the sky

  size_t texel_of(const Vec3f& unit_direction) const;
  Vec3f direction(size_t texel) const;
  bool seen(size_t texel) const { return distance[texel] > 0; }
  // Corners are texels with a wall; colours are their radiance; facing the centre.
  TriMesh shell() const;
  double wall_share() const;  // of the sphere
};

// What photos could triangulate is a surface; what lies clearly beyond all of it, seen from the middle of the mesh's box, is sky.
// The largest float without a triangulated point.
float distance_to_sky(std::span<const Vec3f> triangulated, const Bounds3& inner);

Surroundings surroundings(const SplatLayer& diffuse, const SurroundingsDesc& desc);

}  // namespace vitrine
