// A test of a page in headless Chromium: scripts (tests/pages/*.mjs) run in the folder of the build where their packages are.
#pragma once

#include <cstdlib>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "stages/page_text.h"
#include "tests/support/child_program.h"

namespace vitrine {

inline Said run_script(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "node");
  return run_in(PAGES_DIR, arguments);
}

// Empty, or what these tests lack on this machine.
inline std::string lacking() {
  if (!find_program("node")) return "node is missing (Debian: apt-get install nodejs npm)";
  if (!fs::exists(fs::path(PAGES_DIR) / "node_modules/puppeteer-core"))
    return fmt::format("puppeteer-core is not in {}: npm could not install it; build again", PAGES_DIR);
  for (const char* stage : {"view", "mark", "tomography"})
    if (!fs::exists(empty_page_path(stage)))
      return fmt::format("{} is missing: npm could not install its packages; build again", empty_page_path(stage).string());
  const Said said = run_script({"chromium.mjs"});
  return said.code == 0 ? "" : said.out;
}

// Skips where something is missing, unless VITRINE_NEED_CHROMIUM is set, as tests/run.sh does: then it fails.
class InChromium : public testing::Test {
 protected:
  void SetUp() override {
    const std::string reason = lacking();
    if (reason.empty()) return;
    ASSERT_EQ(std::getenv("VITRINE_NEED_CHROMIUM"), nullptr) << reason;
    GTEST_SKIP() << reason;
  }
  // Where a test leaves pictures to look at: empty.
  static fs::path pictures(const std::string& name) {
    const fs::path out = fs::path(PAGES_DIR) / "pictures" / name;
    fs::remove_all(out);
    make_folders(out);
    return out;
  }
  // The JSON that a script printed as its last line; empty, and a failure, without one.
  static nlohmann::json answer(const Said& said) {
    EXPECT_EQ(said.code, 0) << said.out;
    const size_t begin = said.out.rfind("\n{");
    const std::string last = said.out.substr(begin == std::string::npos ? 0 : begin + 1);
    return said.code == 0 && last.starts_with('{') ? nlohmann::json::parse(last) : nlohmann::json::object();
  }
};

}  // namespace vitrine
