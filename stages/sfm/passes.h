// Detection of an object that was moved against its surroundings between passes of photos. Typical capture: one pass of photos,
// turn the object over, second pass. Between the passes the object and its surroundings have different rigid motions, so no
// single set of poses fits both.
//
// Input: pairs of photos, with poses computed from some of the features. On each side (object, surroundings) a pair
//   agrees       at least 15 matches fit the poses, and half of all
//   contradicts  the other side agrees, and either at least 25 matches do not fit, or the cameras have nearly the same viewing
//                direction and hardly any match fits, although both photos have features of this side
// Photos connected by agreeing pairs form a group. Two groups of at least 3 photos with at least 3 contradicting pairs between
// them are two passes.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"
#include "stages/sfm/reconstruct.h"

namespace vitrine {

inline constexpr size_t kSmallestPass = 3;  // photos

struct MotionEvidence {
  Passes passes;              // fewer than two: no contradiction
  size_t pairs = 0;           // pairs in which one side contradicts
  double furthest_match = 0;  // degrees between the viewing directions of photos that agree on the object, 90 % quantile
};

// `on_object` [photo][feature]: 1 = on the object. `matches`: by descriptors, before verification.
MotionEvidence motion_evidence(const ColmapModel& poses, const FoundMatches& matches,
                               std::span<const std::vector<uint8_t>> on_object);

// Same from two sets of poses: groups of at least 3 photos in which the object has the same orientation relative to its
// surroundings, within 5 degrees. Photos of different models of the surroundings (the largest first) are in different groups.
// Empty if no model has two groups: the object was not moved.
Passes passes_by_motion(const ColmapModel& object, std::span<const ColmapModel> surroundings);

// True if the object has another orientation in most photos, as on a turntable in a visible room.
bool turns_in_most_photos(const ColmapModel& object, std::span<const ColmapModel> surroundings);

// The photos of `model` that are listed in `photos`, and the points that they observe.
ColmapModel restricted(const ColmapModel& model, const std::vector<std::string>& photos);

}  // namespace vitrine
