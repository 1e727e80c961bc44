// Mesh cleaning after repair: removal of small components, Taubin smoothing (1995), quadric decimation (Garland and Heckbert
// 1997, by OpenMesh). Vertex colours and object ids are kept, normals are not: call vertex_normals() afterwards.
#pragma once

#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {

struct ComponentRule {
  double min_fraction = 0.005;  // of all faces; smaller components are removed
  int keep_largest = 0;         // maximum number of components kept; 0 = no limit
};
TriMesh without_small_components(const TriMesh& mesh, const ComponentRule& rule);

struct TaubinDesc {
  int iterations = 5;
  float lambda = 0.5f, mu = -0.53f;  // shrink, then inflate: a low-pass filter that preserves the volume
};
// Boundary vertices move along the boundary only.
void taubin_smooth(TriMesh& mesh, const TaubinDesc& desc);

struct DecimateDesc {
  size_t target_faces = 200000;
  double max_normal_turn_deg = 60;    // maximum rotation of a face normal by a collapse
  double max_boundary_turn_deg = 20;  // boundary vertices are collapsed only where the boundary turns less than this
};
// Result has at most target_faces unless the rules forbid all further collapses. Non-manifold input is split at its
// non-manifold edges and vertices, not rejected.
TriMesh decimated(const TriMesh& mesh, const DecimateDesc& desc);

}  // namespace vitrine
