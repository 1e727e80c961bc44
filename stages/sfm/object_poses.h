// Camera poses for captures in which the object was moved between passes of photos (passes.h). With object masks, the object's
// features join the passes; within a pass all features are used, because the surroundings did not move relative to the object.
#pragma once

#include "stages/sfm/normalize.h"
#include "stages/sfm/passes.h"
#include "stages/stage.h"

namespace vitrine {

struct ObjectPasses {
  Passes passes = {};  // empty: no motion of the object detected
  PosesOf poses = PosesOf::Object;
  size_t contradicting = 0;  // pairs of photos
  bool joined() const { return !passes.empty() && poses == PosesOf::Object; }
  double furthest_match = 0;  // degrees between the viewing directions of photos that still match on the object
};

// `together`: the reconstruction from all features. Replaced by that from the object's features if these prove that the object
// was moved, or by the photos of the largest pass if they do not join the passes. `masks` contains object masks.
ObjectPasses poses_of_object(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, const FeatureMasks& masks,
                             Reconstruction& together);

// Without object masks the poses are kept, whether they follow the surroundings or the object.
ObjectPasses passes_without_masks(const ReconstructDesc& desc, const Reconstruction& together);

// Removes the points that lie outside the object in most of their photos: the surroundings have another position in each pass.
ColmapModel object_points(const ColmapModel& model, std::span<const SfmPhoto> photos, const FeatureMasks& masks);

// What the stage says of the passes, and sfm/passes.json. `up`: the option, for the elevation of the cameras of `model`.
void report_passes(const ObjectPasses& passes, const ColmapModel& model, UpMethod up, StageContext& context);

}  // namespace vitrine
