// A smooth closed mesh whose silhouettes the masks are: for objects of any form that no simple shape fits. A visual hull bulges
// between the cones of its photos and has their edges, and masks with something in front of the object cut it. Here every photo
// says along its line of sight's contact with the mesh how far the mask's edge is away; the vertices follow the most of them,
// and the surface bends as little as it can (thin-plate energy, Kobbelt et al., "Interactive Multi-Resolution Modeling on
// Arbitrary Meshes", 1998), so that what no photo sees at a silhouette continues what they see.
#pragma once

#include <span>

#include "core/scene/mesh/tri_mesh.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

struct MeshFitDesc {
  int rounds = 40;
  double reach = 0.08;       // of the size of the mesh: how far from it the edge of a mask is looked for, at first
  double last_reach = 0.03;  // and at last
  double first_stiffness = 300, stiffness = 3;  // weight of bending against one photo's contact, for edges of mean length
};

struct MeshFit {
  TriMesh mesh;         // with normals
  double residual = 0;  // median distance between contacts and edges of masks, scene units
  double contacts = 0;  // share of the vertices that photos see at a silhouette
};

// `start`: closed, counter-clockwise from outside, such as a hull; edges of about one length. Unknown pixels (value < 0) say
// nothing. The same for any number of threads.
MeshFit fit_mesh(std::span<const Silhouette> masks, TriMesh start, const MeshFitDesc& desc = {});

}  // namespace vitrine
