// Results of a run for the page: cameras, and the propagated masks, resampled to the original (distorted) photos in which people
// annotate.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera/mask_class.h"
#include "core/scene/camera/view.h"

namespace vitrine {

// Run-length encoded mask, row by row: alternating lengths of outside and inside runs, starting outside.
using MaskRuns = std::vector<int>;

struct RunPhoto {
  View view;                                                   // of the undistorted photo
  double width = 0, height = 0;                                // of the photo as ingested, distorted
  int mask_width = 0, mask_height = 0;                         // of the masks below
  std::array<std::optional<MaskRuns>, kMaskClassCount> masks;  // [class] in the frame of the original photo
};

struct RunResults {
  std::map<std::string, RunPhoto> photos;      // by name; photos with a camera
  std::map<std::string, std::string> sources;  // class -> source of its masks: "boxes", "proposed"
};

// `masks`: artifact of the masks stage, optional. Throws Error{Input}.
RunResults read_run_results(const std::filesystem::path& sfm, const std::optional<std::filesystem::path>& masks);

}  // namespace vitrine
