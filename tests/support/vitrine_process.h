// The real program `vitrine` run as a child process in a temporary folder, and what it left there.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"

namespace vitrine {

struct Outcome {
  int exit = -1;
  std::string text;  // stdout and stderr, in order of arrival
  bool has(const std::string& part) const { return text.find(part) != std::string::npos; }
  // The same wherever the console has broken its lines.
  bool said(const std::string& part) const { return on_one_line(text).find(on_one_line(part)) != std::string::npos; }
  static std::string on_one_line(const std::string& lines) {
    std::istringstream in(lines);
    std::string all;
    for (std::string word; in >> word;) all += (all.empty() ? "" : " ") + word;
    return all;
  }
};

class VitrineProcess : public testing::Test {
 protected:
  VitrineProcess() {
    setenv("XDG_CONFIG_HOME", (folder.path() / "home").c_str(), 1);
    unsetenv("VITRINE_SET");
  }
  virtual fs::path photos() const = 0;
  fs::path out() const { return folder.path() / "out ö"; }

  static std::vector<std::string> words(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(VITRINE_BIN_DIR) + "/vitrine");
    return arguments;
  }
  Outcome call(const std::vector<std::string>& arguments) const {
    Outcome o;
    const ProcessResult r =
        run_process({.arguments = words(arguments), .working_folder = folder.path(), .on_line = [&](std::string_view line) {
                       o.text += std::string(line) + "\n";
                     }});
    o.exit = r.signal != 0 ? 128 + r.signal : r.exit_code;
    return o;
  }
  Outcome run(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"run", photos().string(), "-o", out().string()});
    return call(more);
  }
  // Starts `vitrine` without waiting for it.
  pid_t start(const std::vector<std::string>& arguments) const {
    const std::vector<std::string> all = words(arguments);
    const pid_t child = fork();
    if (child != 0) return child;
    std::vector<char*> argv;
    for (const std::string& w : all) argv.push_back(const_cast<char*>(w.c_str()));
    argv.push_back(nullptr);
    execv(argv[0], argv.data());
    _exit(99);
  }
  static int wait_for(pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }

  // stage -> "ran", "cached", ... of the last run, from run.json.
  std::map<std::string, std::string> states() const {
    std::map<std::string, std::string> all;
    const auto run = nlohmann::json::parse(read_file(out() / "run.json"));
    for (const auto& s : run.at("stages")) all[s.at("name")] = s.at("state");
    return all;
  }
  // stage -> content digest of its current artifact.
  std::map<std::string, std::string> digests() const {
    std::map<std::string, std::string> all;
    ArtifactStore store(store_of(out()));
    for (const auto& [stage, key] : current_keys(out())) all[stage] = store.find(stage, key)->content_digest;
    return all;
  }

  TemporaryFolder folder{"vitrine test"};
};

using States = std::map<std::string, std::string>;

}  // namespace vitrine
