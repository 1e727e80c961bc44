// Groups of photos with one focal length: without EXIF, a zoom lens, a phone with two lenses and digital zoom leave photos of one
// size that one camera cannot describe.
#pragma once

#include <span>
#include <vector>

namespace vitrine {

struct FocalGroup {
  double focal = 0;             // median, pixels
  std::vector<size_t> members;  // indices into the focal lengths given
};

// Groups of focal lengths (pixels, 0 = unknown), shortest first: of 3 or more members, most of them within 10 % of the median of
// the group, and 15 % apart from each other; outliers belong to the nearest group, unknown ones to none. Empty: there are not two
// groups, or less than three quarters of the known ones are in groups.
std::vector<FocalGroup> focal_groups(std::span<const double> focals);

}  // namespace vitrine
