// Was the object moved against its surroundings between groups of photos? Object photography works in passes: a pass of photos,
// the object turned over, a second pass. Between two passes the object has one motion and its surroundings have another, so that
// no poses fit both.
//
// Evidence is collected for pairs of photos, with poses that some of the features decided. On each side (the object, its
// surroundings) a pair
//   agrees       at least 15 matches fit the poses, and half of all
//   contradicts  the other side agrees, and either at least 25 matches exist that do not fit, or the cameras look from nearly the
//                same direction and hardly a match fits, although both photos have features of this side
// Photos that pairs connect by agreement are a group. Two groups of at least 3 photos with at least 3 contradicting pairs between
// them are two passes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/passes.h"
#include "stages/sfm/reconstruct.h"

namespace vitrine {

inline constexpr size_t kSmallestPass = 3;  // photos

struct MotionEvidence {
  Passes passes;              // fewer than two: nothing contradicts
  size_t pairs = 0;           // pairs in which one side contradicts
  double furthest_match = 0;  // degrees between the viewing directions of photos that agree on the object, 90 % quantile
};

// `on_object` [photo][feature]: 1 where the feature lies on the object. `matches`: by descriptors, before any verification.
MotionEvidence motion_evidence(const ColmapModel& poses, const FoundMatches& matches,
                               std::span<const std::vector<uint8_t>> on_object);

// The same by two sets of poses: groups of at least 3 photos in which the object stands alike relative to its surroundings, to 5
// degrees. Photos of different models of the surroundings (the largest first) are in different groups. Fewer than two groups
// within each model: nothing was moved, and the result is empty.
Passes passes_by_motion(const ColmapModel& object, std::span<const ColmapModel> surroundings);

// The same way: the object stands otherwise in most photos, as on a turntable before a room that is seen, too.
bool turns_in_most_photos(const ColmapModel& object, std::span<const ColmapModel> surroundings);

// The photos of `model` that are in `photos`, and the points that they see.
ColmapModel restricted(const ColmapModel& model, const std::vector<std::string>& photos);

}  // namespace vitrine
