// Shape detection: fits a shape to the silhouettes of a glass or specular object.
#pragma once

#include "core/scene/shape/shape_set.h"
#include "stages/objects/masked_objects.h"

namespace vitrine {

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
