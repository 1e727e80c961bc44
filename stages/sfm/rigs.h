// Views cut from one panorama are cameras of one rig: known rotations, one centre. COLMAP's mapper poses each view alone; here
// the views get one pose per panorama, which is then adjusted with the points. Views that the mapper did not register take it,
// too.
#pragma once

#include <span>

#include "stages/sfm/reconstruct.h"

namespace vitrine {

class StageContext;

bool has_rigs(std::span<const SfmPhoto> photos);

// Poses and exact lenses of all photos of a rig of which at least one is in `model`, and the other images of `model` unchanged;
// without points. The pose of a rig is the L1 mean over its views (geometric median of the centres, rotations likewise),
// weighted by their observations. `photos`: sorted by name.
ColmapModel with_rig_poses(const ColmapModel& model, std::span<const SfmPhoto> photos);

// Replaces the model: rig poses, points triangulated from the matches of `r.database`, one adjustment with one pose per rig
// (gains/rig_adjustment.h), both twice. Photos of the rigs count as registered.
void one_pose_per_rig(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc, Reconstruction& r,
                      StageContext& context);

}  // namespace vitrine
