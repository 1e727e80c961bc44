// Which shape an object of glass or metal has, by its silhouettes.
#pragma once

#include "core/scene/shape/shape_set.h"
#include "stages/objects/masked_objects.h"

namespace vitrine {

// The shapes of an object, of role Sheet for glass, Mirror for the rest: a box; else a surface of revolution with its appendages
// as meshes; else a mesh fitted to the silhouettes, where most of its pixels lie inside the masks; else the visual hull, as a
// mesh that is not exact, whose tolerance is kHullTolerance_voxels. None where the hull has no faces. `propagated`: the masks are
// not drawn to a pixel.
ShapeSet detected_shapes(const MaskedObject& object, const CarvingRule& rule, bool propagated);
inline constexpr double kHullTolerance_voxels = 3;  // a hull stands out of its object by so much

// How shapes and masks agree, over all photos.
struct MaskAgreement {
  double inside = 0;   // share of the pixels of the shapes' silhouettes that the masks mark
  double covered = 0;  // share of the marked pixels that the shapes' silhouettes cover
};
// Of all the shapes; pixels whose mask is unknown do not count. Silhouettes are looked at with 240 pixels at most.
MaskAgreement mask_agreement(const ShapeSet& shapes, const std::vector<Silhouette>& silhouettes);

}  // namespace vitrine
