// Runs are kept, resumed and never mixed; the trainings are made up.
#include "tests/bench/optics/protocol.h"

#include <mutex>

#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using nlohmann::json;

OpticsRun run_of(const std::string& scene, const std::string& arm, int seed = 1) {
  return {scene,
          arm,
          seed,
          {{"options", {{"optimize.iterations", "1000"}}}, {"programs", {{"optimize", "aaaa"}}}},
          {{"programs", {{"evaluate", "bbbb"}}}}};
}

class OpticsProtocol : public testing::Test {
 protected:
  OpticsOutcome run(const std::vector<OpticsRun>& runs, int jobs = 1) {
    const OpticsWork what{.train =
                              [this](const OpticsRun& r) {
                                const std::scoped_lock lock(mutex);
                                if (r.name() == broken_training) throw Error(ErrorKind::Diverged, "the loss is no number");
                                trained.push_back(r.name());
                                return json{{"cpu_s", 12.0}, {"artifact", r.name()}};
                              },
                          .measure =
                              [this](const OpticsRun& r, const json& before) {
                                const std::scoped_lock lock(mutex);
                                EXPECT_EQ(before.at("artifact"), r.name());
                                if (r.name() == stopped_at) throw Error(ErrorKind::Interrupted, "stopped");
                                measured.push_back(r.name());
                                return Figures{{"all", 20.0 + r.training_seed}};
                              }};
    return run_optics(runs, work.path(), jobs, what, [this](const std::string& line) { lines.push_back(line); });
  }
  TemporaryFolder work;
  std::mutex mutex;
  std::vector<std::string> trained, measured, lines;
  std::string broken_training, stopped_at;
};

using Names = std::vector<std::string>;

TEST_F(OpticsProtocol, FinishedRunsAreNotDoneAgain) {
  const std::vector<OpticsRun> runs{run_of("a", "diffuse"), run_of("a", "full", 2)};
  const OpticsOutcome first = run(runs);
  EXPECT_EQ(trained, (Names{"a diffuse seed 1", "a full seed 2"}));
  const OpticsOutcome second = run({runs[0], runs[1], run_of("b", "diffuse")});
  EXPECT_EQ(trained, (Names{"a diffuse seed 1", "a full seed 2", "b diffuse seed 1"}));
  EXPECT_EQ(measured, trained);
  ASSERT_EQ(second.results.size(), 3u);
  EXPECT_EQ(second.results[1].figures, first.results[1].figures);
  EXPECT_EQ(second.results[1].figures, (Figures{{"all", 22.0}, {"cpu_s", 12.0}}));
  EXPECT_TRUE(second.failures.empty());
}

TEST_F(OpticsProtocol, WhatWasInterruptedBetweenTrainingAndMeasurementIsMeasuredAlone) {
  stopped_at = "a full seed 1";
  const std::vector<OpticsRun> runs{run_of("a", "diffuse"), run_of("a", "full"), run_of("b", "full")};
  EXPECT_EQ(error_of([&] { run(runs); }).kind(), ErrorKind::Interrupted);
  EXPECT_EQ(trained.size(), 2u);
  stopped_at.clear();
  EXPECT_EQ(run(runs).results.size(), 3u);
  EXPECT_EQ(trained, (Names{"a diffuse seed 1", "a full seed 1", "b full seed 1"}));
  EXPECT_EQ(measured, (Names{"a diffuse seed 1", "a full seed 1", "b full seed 1"}));
}

TEST_F(OpticsProtocol, OtherSettingsOfATrainingAreRefusedBeforeAnythingRuns) {
  run({run_of("a", "diffuse")});
  OpticsRun longer = run_of("a", "diffuse");
  longer.training["options"]["optimize.iterations"] = "2000";
  Error e = error_of([&] { run({run_of("b", "diffuse"), longer}); });
  EXPECT_EQ(e.kind(), ErrorKind::Usage);
  EXPECT_EQ(exit_code(e.kind()), 2);
  EXPECT_EQ(e.detail().why, "options/optimize.iterations: 1000, now 2000");
  EXPECT_NE(e.detail().where.find("runs/a/diffuse/seed_1.json"), std::string::npos);
  OpticsRun rebuilt = run_of("a", "diffuse");
  rebuilt.training["programs"]["optimize"] = "cccc";
  e = error_of([&] { run({rebuilt}); });
  EXPECT_EQ(e.detail().why, "programs/optimize: aaaa, now cccc");
  EXPECT_EQ(trained, Names{"a diffuse seed 1"});
}

TEST_F(OpticsProtocol, AnotherEvaluationMeasuresAgainWithoutTraining) {
  run({run_of("a", "diffuse")});
  OpticsRun other = run_of("a", "diffuse");
  other.measuring["programs"]["evaluate"] = "dddd";
  run({other});
  EXPECT_EQ(trained.size(), 1u);
  EXPECT_EQ(measured.size(), 2u);
  run({other});
  EXPECT_EQ(measured.size(), 2u);
}

TEST_F(OpticsProtocol, ARunThatFailsIsNamedTriedAgainAndStopsNoOther) {
  broken_training = "a full seed 1";
  const std::vector<OpticsRun> runs{run_of("a", "full"), run_of("b", "full")};
  const OpticsOutcome outcome = run(runs);
  ASSERT_EQ(outcome.results.size(), 1u);
  EXPECT_EQ(outcome.results[0].scene, "b");
  ASSERT_EQ(outcome.failures.size(), 1u);
  EXPECT_NE(outcome.failures[0].find("a full seed 1: the loss is no number"), std::string::npos) << outcome.failures[0];
  broken_training.clear();
  EXPECT_EQ(run(runs).results.size(), 2u);
}

TEST_F(OpticsProtocol, TwoJobsDoEachRunOnceAndKeepTheOrder) {
  std::vector<OpticsRun> runs;
  for (int seed = 1; seed <= 40; ++seed) runs.push_back(run_of("a", "full", seed));
  const OpticsOutcome outcome = run(runs, 2);
  EXPECT_EQ(trained.size(), 40u);
  EXPECT_EQ(lines.size(), 40u);
  ASSERT_EQ(outcome.results.size(), 40u);
  for (int i = 0; i < 40; ++i) EXPECT_EQ(outcome.results[size_t(i)].training_seed, i + 1);
}

TEST_F(OpticsProtocol, ADamagedRecordIsAnErrorThatNamesIt) {
  const OpticsRun r = run_of("a", "full");
  make_folders(file_of_run(work.path(), r).parent_path());
  write_file(file_of_run(work.path(), r), "{\"format\": ");
  const Error e = error_of([&] { run({r}); });
  EXPECT_EQ(e.detail().code, "BAD_RECORD");
  EXPECT_EQ(e.detail().where, file_of_run(work.path(), r).string());
}

}  // namespace
}  // namespace vitrine
