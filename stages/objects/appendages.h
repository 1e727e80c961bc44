// Appendages of surfaces of revolution, as meshes: handles and knobs, which the visual hull contains and the surface does not.
#pragma once

#include <span>

#include "core/scene/mesh/tri_mesh.h"
#include "core/observe/stereo/revolution_fit.h"
#include "stages/objects/masked_objects.h"

namespace vitrine {

// Parts of the object's visual hull that reach at least 0.3 of a solid's largest radius outside all solids, with their roots,
// where photos see them; at most 8000 faces, normals per vertex. `propagated`: the masks are not pixel-accurate, but propagated
// from marks in a few photos.
TriMesh appendages(const MaskedObject& object, std::span<const SurfaceOfRevolution> solids, const CarvingRule& rule,
                   bool propagated);

}  // namespace vitrine
