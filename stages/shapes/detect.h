// Which shape an object of glass or of polished metal has, by its silhouettes.
#pragma once

#include "core/shape/shape_set.h"
#include "stages/shapes/objects.h"

namespace vitrine {

// A box; else a surface of revolution with its appendages as meshes, one entry a solid; else, with `free_forms`, a mesh
// (free_form.h); else nothing. Of role Sheet for glass, Mirror for the rest. `propagated`: the masks are not drawn to a pixel.
ShapeSet detected_shapes(const MaskedObject& object, const CarvingRule& rule, bool propagated, bool free_forms = true);

// How shapes and masks agree, over all photos.
struct MaskAgreement {
  double inside = 0;   // share of the pixels of the shapes' silhouettes that the masks mark
  double covered = 0;  // share of the marked pixels that the shapes' silhouettes cover
};
// Of one entry and its appendages; pixels whose mask is unknown do not count. Silhouettes are looked at with 240 pixels at most.
MaskAgreement mask_agreement(const ShapeSet& set, size_t entry, const std::vector<Silhouette>& silhouettes);

}  // namespace vitrine
