// The stage's world in a test: folders, and a hook after every step.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <map>

#include "core/foundation/base/file.h"
#include "stages/optimize/optimize.h"
#include "stages/stage.h"

namespace vitrine::testing {

// A run on photos of 48x36 pixels that takes a second.
inline OptimizeConfig tiny_config(int iterations) {
  OptimizeConfig config;
  config.iterations = iterations;
  config.max_gaussians = 1500;
  config.initial.frustum_points = 500;
  config.initial.stereo_side = 24;
  config.densify.every = 10;
  config.preview_every = 0;
  config.holdout_every = 6;
  return config;
}

struct Stopped {};

class TestContext final : public StageContext {
 public:
  TestContext(fs::path sfm, fs::path work) : sfm_(std::move(sfm)), output_(work / "output"), scratch_(work / "scratch") {
    make_folders(output_);
    make_folders(scratch_);
  }
  fs::path input(std::string_view name) const override {
    EXPECT_EQ(name, "sfm");
    return sfm_;
  }
  std::optional<fs::path> optional_input(std::string_view name) const override {
    return name == "masks" ? masks : name == "objects" ? objects : std::nullopt;
  }
  const fs::path& output() const override { return output_; }
  const fs::path& scratch() const override { return scratch_; }
  int threads() const override { return thread_count; }
  size_t max_memory_bytes() const override { return memory; }
  void progress(const Progress& p) override {
    last_progress = p;
    const auto& called = p.text.starts_with("opaque twin") ? after_twin_step : after_step;
    if (called) called(int(p.values.at("step")));
  }
  void metric(std::string_view name, double value) override { metrics[std::string(name)] = value; }
  void warning(std::string_view code, std::string_view) override { warnings.emplace_back(code); }
  void summary(std::string_view text) override { summary_text = text; }
  void timing(std::string_view name, double seconds) override { timings[std::string(name)] = seconds; }

  int thread_count = 2;
  size_t memory = 0;
  std::optional<fs::path> masks, objects;                // artifacts of these stages
  std::function<void(int)> after_step, after_twin_step;  // of the layers; of the opaque twin, before
  Progress last_progress;
  std::map<std::string, double> metrics, timings;
  std::vector<std::string> warnings;
  std::string summary_text;

 private:
  fs::path sfm_, output_, scratch_;
};

}  // namespace vitrine::testing
