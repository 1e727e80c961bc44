// Programs of others, run in the folder of the build where their packages are installed.
#pragma once

#include <string>
#include <vector>

#include "core/base/process.h"

namespace vitrine {

struct Said {
  int code = -1;
  std::string out;
};

// Runs a program in the folder where the packages are installed.
inline Said run_external(const std::vector<std::string>& arguments) {
  Said said;
  const ProcessResult r =
      run_process({.arguments = arguments, .working_folder = EXTERNAL_DIR, .on_line = [&](std::string_view line) {
                     said.out.append(line) += "\n";
                   }});
  said.code = r.signal != 0 ? 128 + r.signal : r.exit_code;
  return said;
}

// Idempotent: npm finds everything in place the second time.
inline Said install() {
  make_folders(EXTERNAL_DIR);
  for (const char* file : {"package.json", "chromium.mjs", "validate.mjs", "render.mjs", "splats.mjs", "open_page.mjs",
                           "view_page.mjs", "mark_page.mjs", "mark_sample.mjs", "mark_run.mjs", "ply.mjs", "view_touch.mjs"})
    write_file(fs::path(EXTERNAL_DIR) / file, read_file(fs::path(VITRINE_SOURCE_DIR) / "tests/external" / file));
  return run_external({"npm", "install", "--no-audit", "--no-fund", "--prefer-offline"});
}

}  // namespace vitrine
