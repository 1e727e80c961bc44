// Poses where the object was moved between passes of photos (passes.h). With masks of the object its own features join the
// passes; within a pass all features find the poses, since there its surroundings stand still with it.
#pragma once

#include "stages/sfm/normalize.h"
#include "stages/sfm/passes.h"
#include "stages/stage.h"

namespace vitrine {

struct ObjectPasses {
  Passes passes = {};  // empty: the object was not moved, as far as the photos show
  PosesOf poses = PosesOf::Object;
  size_t contradicting = 0;  // pairs of photos
  bool joined() const { return !passes.empty() && poses == PosesOf::Object; }
  double furthest_match = 0;  // degrees between the viewing directions of photos that still match on the object
};

// `together`: what all features gave. Replaced by the reconstruction of the object's features where these show that the object
// was moved, or by the photos of the largest pass where they do not join the passes. `masks` has masks of the object.
ObjectPasses poses_of_object(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const FeatureMasks& masks,
                             Reconstruction& together);

// Without masks of the object the poses stay what they are, of its surroundings or its own.
ObjectPasses passes_without_masks(const ReconstructDesc& desc, const Reconstruction& together);

// Without the points that most of their photos show outside the object: what surrounds it stands elsewhere in each pass.
ColmapModel object_points(const ColmapModel& model, std::span<const SfmPhoto> photos, const FeatureMasks& masks);

// What the stage says of the passes, and sfm/passes.json. `up`: the option, for the elevation of the cameras of `model`.
void report_passes(const ObjectPasses& passes, const ColmapModel& model, UpMethod up, StageContext& context);

}  // namespace vitrine
