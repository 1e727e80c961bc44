// Appendages of surfaces of revolution: handles and knobs, which a fine visual hull has and the surface has not.
#pragma once

#include <span>

#include "core/scene/mesh/tri_mesh.h"
#include "core/observe/stereo/revolution_fit.h"
#include "stages/objects/masked_objects.h"

namespace vitrine {

// The parts of the object's hull that reach at least 0.3 of a solid's largest radius out of all solids, with their roots, as far
// as photos look at them; at most 8000 faces, normals per vertex. `propagated`: the masks are not drawn to a pixel, but
// propagated from marks of few photos.
TriMesh appendages(const MaskedObject& object, std::span<const SurfaceOfRevolution> solids, const CarvingRule& rule,
                   bool propagated);

}  // namespace vitrine
