// Fits a box or surfaces of revolution to the silhouettes of one mask class or one object.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/observe/stereo/box_fit.h"
#include "core/observe/stereo/revolution_fit.h"
#include "core/observe/stereo/silhouette.h"
#include "core/observe/stereo/visual_hull.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/surface_of_revolution.h"

namespace vitrine {

struct FittedShapes {
  std::optional<BoxFit> box;                // else:
  std::vector<SurfaceOfRevolution> solids;  // one for each connected component of the visual hull that is one
};
FittedShapes fit_shapes(std::span<const Silhouette> silhouettes, const VisualHull& hull);

// Fits a sphere to a surface of revolution. Photos from one height see no contour of the top and the foot of a ball, occluders
// hide parts of it, and a free profile ends in cones there; the four parameters of a sphere follow from any part of it. Returns
// the sphere through the flank of `surface`, centred on its axis, where it matches most photos as well as `surface`; else
// nullopt.
std::optional<SurfaceOfRevolution> ball_of(std::span<const Silhouette> silhouettes, const SurfaceOfRevolution& surface);

// Fits a smooth closed mesh to masks, for objects that no simple shape fits. A visual hull bulges between the viewing cones,
// keeps their creases, and loses parts where an occluder cuts a mask. Here each photo measures, at its contour vertices, the
// distance to the edge of the mask; vertices follow a robust average of these distances, regularised by thin-plate energy
// (Kobbelt et al., "Interactive Multi-Resolution Modeling on Arbitrary Meshes", 1998), so that parts without a contour continue
// their surroundings.
struct MeshFitDesc {
  int rounds = 40;
  double reach = 0.08;                          // initial search distance for the edge of a mask, as a share of the mesh size
  double last_reach = 0.03;                     // final search distance
  double first_stiffness = 300, stiffness = 3;  // bending weight against one contour observation, for edges of mean length
};

struct MeshFit {
  TriMesh mesh;         // with normals
  double residual = 0;  // median distance between contours and mask edges, scene units
  double contacts = 0;  // share of the vertices on the contour of some photo
};

// `start`: closed, counter-clockwise from outside, such as a visual hull; edges of about equal length. Unknown pixels (value <
// 0) are ignored. The result does not depend on the number of threads.
MeshFit fit_mesh(std::span<const Silhouette> masks, TriMesh start, const MeshFitDesc& desc = {});

}  // namespace vitrine
