// Search for several focal lengths among the photos of one camera, by the matches: EXIF has none of them, or names one for all.
//
// One camera for photos of two focal lengths gives poses that are wrong by tenths of the distances, and no failure. A bundle
// adjustment in which every photo has its own focal length then explains the same points far better, and the focal lengths form
// groups. The photos are mapped again with a camera for each group, which decides: the cameras must keep their distance, and the
// reprojection error must fall with no fewer photos.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "stages/sfm/reconstruct.h"
#include "stages/stage.h"

namespace vitrine {

struct FocalGroup {
  double focal = 0;             // median, pixels
  std::vector<size_t> members;  // indices into the focal lengths given
};

// Groups of focal lengths (pixels, 0 = unknown), shortest first: of 3 or more members, most of them within 10 % of the median of
// the group, and 15 % apart from each other; outliers belong to the nearest group, unknown ones to none. Empty: there are not two
// groups, or less than three quarters of the known ones are in groups.
std::vector<FocalGroup> focal_groups(std::span<const double> focals);

enum class FocalVerdict {
  One,       // one focal length for each camera explains the photos, or there are too few points for a statement
  Several,   // cameras were separated
  Unsorted,  // photos fit clearly better with a focal length each, but no groups were found, or cameras for them do not help
};
inline constexpr const char* kFocalVerdictWords[] = {"one", "several", "unsorted"};

struct FocalSearch {
  FocalVerdict verdict = FocalVerdict::One;
  double error_before = 0, error_own = 0, error_after = 0;  // pixels: cameras as given, a focal length a photo, cameras as found
  struct Group {
    double focal_px = 0;
    size_t photos = 0;
  };
  std::vector<Group> groups = {};  // of the cameras that were separated, shortest first
  std::string text() const;        // "9 photos of 380 px and 9 of 757 px"
};

// Replaces `together` and extends `desc.photos[].camera` if the photos have several focal lengths; otherwise both stay as they
// are. Costs at most 10 steps of a bundle adjustment where one focal length explains the photos, else 30 and up to three
// mappings.
FocalSearch cameras_by_focal(Colmap& colmap, const SfmConfig& config, ReconstructDesc& desc, Reconstruction& together);

// Log, metric and warning of the result.
void report_focals(const FocalSearch& focals, StageContext& context);

}  // namespace vitrine
