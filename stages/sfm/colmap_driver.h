// COLMAP as a child process: found through $VITRINE_COLMAP or PATH, run without a shell or a display. Options changed names
// between versions, so every option is a word of ours with a row of alternatives, and `colmap <command> -h` decides which one
// this program has. Neither exit codes nor progress lines are trusted: callers look at the files that a command should have left.
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

// A setting of a COLMAP command in our words (see the table in colmap_driver.cpp), or a literal "--Group.option".
struct ColmapSetting {
  std::string word;
  std::string value;
  bool required = true;  // false: left out where this version has no such option
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
  // Throws Error{Dependency} when there is no such program, or it does not answer like COLMAP.
  Colmap();
  explicit Colmap(fs::path program);

  const fs::path& program() const { return program_; }
  const std::string& version() const { return version_; }  // "3.8"
  // The option's name in this version, e.g. "--SiftExtraction.use_gpu"; nullopt when the help shows none of the alternatives.
  std::optional<std::string> option(const std::string& command, const std::string& word);
  // The full argument list; throws Error{Dependency} that names a missing required option and the version.
  std::vector<std::string> arguments(const ColmapCommand& call);
  // Runs it. A command that could not be started or was killed by a signal of ours throws; everything else is the caller's
  // to judge by the files.
  ProcessResult run(const ColmapCommand& call);

 private:
  const std::set<std::string>& options_of(const std::string& command);
  fs::path program_;
  std::string version_;
  std::map<std::string, std::set<std::string>> help_;
};

// Version of the COLMAP that a run would use, or "none": a term of the cache key.
std::string colmap_fingerprint();

}  // namespace vitrine
