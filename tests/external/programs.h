// Programs of others, run in the folder of the build where their packages are installed.
#pragma once

#include "tests/support/child_program.h"

namespace vitrine {

inline Said run_external(const std::vector<std::string>& arguments) { return run_in(EXTERNAL_DIR, arguments); }

// Idempotent: npm finds everything in place the second time.
inline Said install() {
  make_folders(EXTERNAL_DIR);
  for (const char* file : {"external/package.json", "external/draw.mjs", "external/validate.mjs", "external/render.mjs",
                           "external/splats.mjs", "external/ply.mjs", "pages/chromium.mjs"})
    write_file(fs::path(EXTERNAL_DIR) / fs::path(file).filename(), read_file(fs::path(VITRINE_SOURCE_DIR) / "tests" / file));
  return run_external({"npm", "install", "--no-audit", "--no-fund", "--prefer-offline"});
}

}  // namespace vitrine
