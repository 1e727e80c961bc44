// Objects and their shapes from the masks of a class: components of the visual hull, rectangles, fitted shapes, fine hulls and
// appendages.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"
#include "core/observe/stereo/carving.h"
#include "core/observe/stereo/revolution_fit.h"
#include "core/observe/stereo/silhouette.h"
#include "core/observe/stereo/visual_hull.h"
#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/shape/shape_set.h"

namespace vitrine {

// Separation of glass and specular objects: splits the masks of a class by the connected components of their visual hull.

struct MaskedObject {
  MaskClass kind = MaskClass::Transparent;
  std::vector<Silhouette> silhouettes;  // pixels of other objects of the class are unknown
  VisualHull hull;                      // not empty
};

// `silhouettes`: of all objects of the class. Empty if no closed region is consistent with them, e.g. for a window. Components
// smaller than a fiftieth of the largest are dropped: the cones of a few photos also intersect in empty space.
std::vector<MaskedObject> masked_objects(MaskClass kind, const std::vector<Silhouette>& silhouettes, const HullDesc& desc);

// Detection of rectangles in the masks of a class: windows, pictures under glass, mirrors on walls.

// Role Sheet for glass, Mirror otherwise. `one_sided`: only rectangles that no photo sees from behind.
ShapeSet open_planes(MaskClass kind, std::span<const Silhouette> silhouettes, std::span<const ScenePoint> points, bool one_sided);

// The silhouettes, with the pixels of the shapes set to unknown.
std::vector<Silhouette> unexplained(std::span<const Silhouette> silhouettes, const ShapeSet& found);

// Visual hull of a part of an object at subpixel precision. The grid of the whole hull is as coarse as the largest object
// requires: a thin part is six cells wide, with coarse normals. Here the part has a grid of its own, an occupancy field as soft
// as the edges of the masks, and its level set.

// Smoothed, with normals. `known`: result of the whole hull away from its surface: 1 inside, 0 outside; -1 near the surface.
TriMesh fine_hull(const Carving& carving, const Bounds3& bounds, double cell, const std::function<int(const Vec3d&)>& known);

// Mesh of the carved cells of a hull, smoothed in the same way; empty for an empty hull.
TriMesh hull_mesh(const VisualHull& hull);

// Appendages of surfaces of revolution, as meshes: handles and knobs, which the visual hull contains and the surface does not.

// Parts of the object's visual hull that reach at least 0.3 of a solid's largest radius outside all solids, with their roots,
// where photos see them; at most 8000 faces, normals per vertex. `propagated`: the masks are not pixel-accurate, but propagated
// from marks in a few photos.
TriMesh appendages(const MaskedObject& object, std::span<const SurfaceOfRevolution> solids, const CarvingRule& rule,
                   bool propagated);

// Shape detection: fits a shape to the silhouettes of a glass or specular object.

// Shapes of an object, with role Sheet for glass, Mirror otherwise. Tried in order: a box; a surface of revolution with its
// appendages as meshes; a mesh fitted to the silhouettes, if most of its pixels lie inside the masks; the visual hull, as an
// inexact mesh with tolerance kHullTolerance_voxels. Empty if the hull has no faces. `propagated`: the masks are not
// pixel-accurate.
ShapeSet detected_shapes(const MaskedObject& object, const CarvingRule& rule, bool propagated);
inline constexpr double kHullTolerance_voxels = 3;  // a hull exceeds its object by up to this distance

// Overlap of shapes and masks, over all photos.
struct MaskAgreement {
  double inside = 0;   // share of the silhouette pixels that the masks mark
  double covered = 0;  // share of the marked pixels inside the silhouettes
};
// For all the shapes together; pixels with unknown mask do not count. Evaluated at no more than 240 pixels.
MaskAgreement mask_agreement(const ShapeSet& shapes, const std::vector<Silhouette>& silhouettes);

}  // namespace vitrine
