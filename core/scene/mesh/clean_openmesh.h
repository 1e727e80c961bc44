// Cleaning of a repaired mesh: small components away, Taubin smoothing (1995), quadric decimation (Garland and Heckbert 1997,
// by OpenMesh). Colours and ids of objects follow their vertices; normals are not kept: compute vertex_normals() at the end.
#pragma once

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct ComponentRule {
  double min_fraction = 0.005;  // of all faces; smaller components go
  int keep_largest = 0;         // at most so many stay; 0 = no limit
};
TriMesh without_small_components(const TriMesh& mesh, const ComponentRule& rule);

struct TaubinDesc {
  int iterations = 5;
  float lambda = 0.5f, mu = -0.53f;  // shrink, then grow back: a low-pass that keeps the volume
};
// Vertices on a boundary move along it only.
void taubin_smooth(TriMesh& mesh, const TaubinDesc& desc);

struct DecimateDesc {
  size_t target_faces = 200000;
  double max_normal_turn_deg = 60;    // no collapse turns a face further
  double max_boundary_turn_deg = 20;  // a boundary vertex goes only where its boundary is this straight
};
// At most target_faces, unless the rules forbid every further collapse. Non-manifold input is opened, not refused.
TriMesh decimated(const TriMesh& mesh, const DecimateDesc& desc);

}  // namespace vitrine
