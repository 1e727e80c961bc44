// What a run knows of its photos: where their cameras stand, and the masks that the marks became, in the frame of the photos as
// taken, where people draw.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/mask_files.h"
#include "core/camera/view.h"

namespace vitrine {

// A mask row by row: lengths of runs, of pixels outside and inside in turn, beginning outside.
using MaskRuns = std::vector<int>;

struct RunPhoto {
  View view;                                                   // of the undistorted photo
  double width = 0, height = 0;                                // of the photo as ingested, distorted
  int mask_width = 0, mask_height = 0;                         // of the masks below
  std::array<std::optional<MaskRuns>, kMaskClassCount> masks;  // [class] in the photo as taken
};

struct RunResults {
  std::map<std::string, RunPhoto> photos;      // by name: those that have a camera
  std::map<std::string, std::string> sources;  // class -> where its masks come from: "boxes", "proposed"
};

// `masks`: its artifact, if there is one. Throws Error{Input}.
RunResults read_run_results(const std::filesystem::path& sfm, const std::optional<std::filesystem::path>& masks);

}  // namespace vitrine
