// Thin glass or solid? A ball of glass shows the room upside down, where a bottle shows it straight on. Rays are sent through a
// closed shape both ways, to the large planes of the scene, which other photos colour; what the photos of the object look more
// like decides. What stands in the glass is not predicted: a paperweight with a picture in its foot stays undecided.
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
  std::span<const Silhouette> glass;  // of the transparent masks
  int holdout_every;                  // photos that are held out are not looked at
};
// Gives the role solid_glass to objects of glass whose one exact, closed, curved shape the photos show to be solid, and writes
// what they said to their evidence. Where stereo finds too little, or too few pixels tell, nothing is said.
void find_solids(ObjectSet& set, const SolidTrialDesc& desc);

}  // namespace vitrine
