// A program of others, run in a folder of the build.
#pragma once

#include <string>
#include <vector>

#include "core/foundation/base/process.h"

namespace vitrine {

struct Said {
  int code = -1;
  std::string out;
};

inline Said run_in(const fs::path& folder, const std::vector<std::string>& arguments) {
  Said said;
  const ProcessResult r = run_process({.arguments = arguments, .working_folder = folder, .on_line = [&](std::string_view line) {
                                         said.out.append(line) += "\n";
                                       }});
  said.code = r.signal != 0 ? 128 + r.signal : r.exit_code;
  return said;
}

}  // namespace vitrine
