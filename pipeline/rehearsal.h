// What `vitrine run` would say of the files it is given, before anything long is computed: the run itself, up to the camera
// poses, on small copies of the photos.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace vitrine {

struct RehearsalDesc {
  std::filesystem::path photos;
  std::string poses = {};  // as --poses; without any, poses would have to be found, which takes minutes: nothing is said
  std::string masks = {};  // as --masks, or empty
  int threads = 0;
};

// A warning or the error with which the run would end.
struct Said {
  bool error = false;
  std::string code = {};  // "POSES_DISAGREE", as the run tells it
  std::string what = {}, why = {}, hint = {};
};

std::vector<Said> rehearsed(const RehearsalDesc& desc);

}  // namespace vitrine
