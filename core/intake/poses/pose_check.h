// Checks given poses against the photos before anything is computed from them. Correct poses, even noisy ones, pass most tests of
// pose_agreement.h; poses in another convention or of other photos pass hardly any. On failure other conventions are tried
// (pose_variants.h), and Error{Input, POSES_DISAGREE} names the one that fits. The same tests resolve what the files leave
// ambiguous: stored or upright pixels, resized or cropped photos.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "core/intake/poses/pose_agreement.h"
#include "core/intake/poses/pose_pixels.h"

namespace vitrine {

struct CheckedPoses {
  ColmapModel model;  // as given, or rotated to fit the photos
  Notes notes;        // results; a warning where a code is set
  Agreement agreement;
  bool checked = false;  // there were enough tests to decide
};

// `matches`: between photos, verified without the poses. `where`: path of the poses, for messages.
CheckedPoses checked_with_matches(ColmapModel model, PosePixels& pixels, std::span<const PhotoMatches> matches,
                                  const std::filesystem::path& where);
// For a model with points: tests its own observations, and the pictures at them.
CheckedPoses checked_with_pictures(ColmapModel model, PosePixels& pixels,
                                   const std::function<Image8(const ColmapImage&)>& picture, const std::filesystem::path& where);

}  // namespace vitrine
