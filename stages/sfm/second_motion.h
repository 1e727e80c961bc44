// Without masks of the object: which features move against those that decided the poses? Of pairs of photos that agree on a
// camera motion, the matches that do not fit it are verified once more by themselves. A second motion is that of an object which
// was moved between the two photos (or of its surroundings, where the object decided).
#pragma once

#include <cstdint>
#include <vector>

#include "stages/sfm/reconstruct.h"

namespace vitrine {

// [photo][feature] 1: it takes part in a second motion of some pair. `matches`: by descriptors, of the reconstruction's database.
std::vector<std::vector<uint8_t>> second_motion_features(Colmap& colmap, const SfmConfig& config, const ReconstructDesc& desc,
                                                         const Reconstruction& r, const FoundMatches& matches);

}  // namespace vitrine
