// The check that given poses agree with the photos, before anything is computed from them. Right poses, even noisy ones, agree
// with most of what the photos say (pose_agreement.h); poses in another convention or of other photos agree with hardly any of
// it. Then other readings are tried (pose_variants.h), and Error{Input, POSES_DISAGREE} names the one that fits. What the files
// left open (are the poses for stored or upright pixels? of resized or cropped pictures?) is decided here by the same measure.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "core/intake/poses/pose_agreement.h"
#include "core/intake/poses/pose_pixels.h"

namespace vitrine {

struct CheckedPoses {
  ColmapModel model;  // as given, or turned as the photos want it
  Notes notes;        // what was found; a warning where a code is set
  Agreement agreement;
  bool checked = false;  // there was enough to tell
};

// `matches`: between photos, verified without the poses. `where`: the poses' path, for messages.
CheckedPoses checked_with_matches(ColmapModel model, PosePixels& pixels, std::span<const PhotoMatches> matches,
                                  const std::filesystem::path& where);
// For a model with points: its own observations, and the pictures at them.
CheckedPoses checked_with_pictures(ColmapModel model, PosePixels& pixels,
                                   const std::function<Image8(const ColmapImage&)>& picture, const std::filesystem::path& where);

}  // namespace vitrine
