// Checks given poses and masks for `vitrine inspect`: executes a run up to the camera poses on reduced copies of the photos.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vitrine {

struct RehearsalDesc {
  std::filesystem::path photos;
  std::string poses = {};  // as --poses; without poses there is no rehearsal, since estimating them takes minutes
  std::string masks = {};  // as --masks, or empty
  int threads = 0;
};

// A warning of the run, or the error that ended it.
struct RunMessage {
  bool error = false;
  std::string code = {};  // code of the run: "POSES_DISAGREE"
  std::string what = {}, why = {}, hint = {};
};

std::vector<RunMessage> rehearsed(const RehearsalDesc& desc);

}  // namespace vitrine
