// COLMAP as a child process. The program is $VITRINE_COLMAP or the first `colmap` on PATH; it runs without a shell and without a
// display. COLMAP renamed options between versions: each option has a name of ours and a list of alternatives, and the output of
// `colmap <command> -h` selects one. Exit codes and progress lines are not reliable: callers check the output files.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/process.h"

namespace vitrine {

// A setting of a COLMAP command: a name of the table in colmap_driver.cpp, or a literal "--Group.option".
struct ColmapSetting {
  std::string word;
  std::string value;
  bool required = true;  // false: omitted where this version has no such option
};

struct ColmapCommand {
  std::string command;  // "feature_extractor"
  std::vector<ColmapSetting> settings;
  fs::path working_folder = {};  // paths in settings may be relative to it
  fs::path log = {};
  std::function<void(std::string_view)> on_line = {};
};

class Colmap {
 public:
  // Throws Error{Dependency} when the program is missing, or its output is not that of COLMAP.
  Colmap();
  explicit Colmap(fs::path program);

  const fs::path& program() const { return program_; }
  const std::string& version() const { return version_; }  // "3.8"
  // Name of the option in this version, e.g. "--SiftExtraction.use_gpu"; nullopt when the help lists none of the alternatives.
  std::optional<std::string> option(const std::string& command, const std::string& word);
  // Full argument list. Throws Error{Dependency} with the missing option and the version.
  std::vector<std::string> arguments(const ColmapCommand& call);
  // Runs the command. Throws when it cannot start or is killed by our signal; the caller checks the files for all other failures.
  ProcessResult run(const ColmapCommand& call);

 private:
  const std::set<std::string>& options_of(const std::string& command);
  fs::path program_;
  std::string version_;
  std::map<std::string, std::set<std::string>> help_;
};

// Version of the COLMAP that a run would use, or "none"; part of the cache key.
std::string colmap_fingerprint();

}  // namespace vitrine
