// Classification of glass as thin or solid. A glass ball shows the room inverted, a bottle shows it straight. Casts rays through
// a closed shape, straight and refracted, to the large planes of the scene, which other photos colour, and compares both
// predictions with the photos of the object. Content inside the glass is not predicted: a paperweight with a picture in its foot
// stays undecided.
#pragma once

#include <filesystem>
#include <span>

#include "core/scene/camera/view_set.h"
#include "core/scene/objects/object_set.h"
#include "core/observe/stereo/silhouette.h"

namespace vitrine {

struct SolidTrialDesc {
  std::filesystem::path sfm;
  const ViewSet& views;
  std::span<const Silhouette> glass;  // silhouettes of the transparent masks
  int holdout_every;                  // held-out photos are not used
};
// Sets the role solid_glass for glass objects with one exact, closed, curved shape that the photos show to be solid, and stores
// both scores in their evidence. No change where stereo or the number of usable pixels is insufficient.
void find_solids(ObjectSet& set, const SolidTrialDesc& desc);

}  // namespace vitrine
