// A StageContext for tests that run a stage in process: inputs by name, a temporary output folder, and everything that the
// stage reported.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "stages/stage.h"

namespace vitrine::test {

class RecordingContext : public StageContext {
 public:
  explicit RecordingContext(std::map<std::string, fs::path> inputs) : inputs_(std::move(inputs)) {}

  fs::path input(std::string_view name) const override {
    const auto path = optional_input(name);
    if (!path) throw Error(ErrorKind::Usage, "missing input " + std::string(name));
    return *path;
  }
  std::optional<fs::path> optional_input(std::string_view name) const override {
    const auto it = inputs_.find(std::string(name));
    return it == inputs_.end() ? std::nullopt : std::optional(it->second);
  }
  const fs::path& output() const override { return output_.path(); }
  const fs::path& scratch() const override { return scratch_.path(); }
  int threads() const override { return thread_limit(); }
  size_t max_memory_bytes() const override { return max_memory; }
  void progress(const Progress& p) override {
    fractions.push_back(p.fraction);
    texts.push_back(p.text);
  }
  void metric(std::string_view name, double value) override { metrics[std::string(name)] = value; }
  void warning(std::string_view code, std::string_view text) override { warnings[std::string(code)] = text; }
  void summary(std::string_view text) override { summary_text = text; }
  void timing(std::string_view, double) override {}

  size_t max_memory = 0;
  std::vector<double> fractions;
  std::vector<std::string> texts;
  std::map<std::string, double> metrics;
  std::map<std::string, std::string> warnings;
  std::string summary_text;

 private:
  std::map<std::string, fs::path> inputs_;
  TemporaryFolder output_, scratch_;
};

}  // namespace vitrine::test
