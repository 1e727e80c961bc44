// Role of an object. The transparent masks give glass. For the specular masks, view dependence decides
// (core/observe/stereo/view_dependence): paint under a clear coat has the same colour from all sides, a mirror does not.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "core/observe/stereo/silhouette.h"
#include "core/observe/stereo/view_dependence.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/objects/object_set.h"
#include "stages/objects/detect.h"

namespace vitrine {

class RoleTest {
 public:
  // `silhouettes`: of the specular masks. Reads their photos once, at reduced size.
  RoleTest(const std::filesystem::path& sfm, std::span<const Silhouette> silhouettes);

  // View dependence of the surface of an object's shapes; opaque shapes of `all` in front of it occlude it. nullopt: too few
  // photos see it.
  std::optional<double> view_dependence(const ShapeSet& all, uint16_t object) const;
  // Same for an object whose shape is a visual hull.
  std::optional<double> view_dependence(const MaskedObject& object) const;

 private:
  std::vector<LuminancePhoto> photos_;
  double spread_ = 0;
};

// `exact`: the shape is more precise than a visual hull. An object seen by too few photos is then a mirror, else a coat, which
// keeps its surfels. `coat_below`: minimum view dependence of a mirror.
ObjectRole object_role_of(MaskClass kind, const std::optional<double>& view_dependence, bool exact, double coat_below);

// Classification of glass as thin or solid. A glass ball shows the room inverted, a bottle shows it straight. Casts rays through
// a closed shape, straight and refracted, to the large planes of the scene, which other photos colour, and compares both
// predictions with the photos of the object. Content inside the glass is not predicted: a paperweight with a picture in its foot
// stays undecided.

struct SolidTrialDesc {
  std::filesystem::path sfm;
  const ViewSet& views;
  std::span<const Silhouette> glass;  // silhouettes of the transparent masks
  std::span<const uint8_t> heldout;   // [view] 1: not used
};
// Sets the role solid_glass for glass objects with one exact, closed, curved shape that the photos show to be solid, and stores
// both scores in their evidence. No change where stereo or the number of usable pixels is insufficient.
void find_solids(ObjectSet& set, const SolidTrialDesc& desc);

}  // namespace vitrine
