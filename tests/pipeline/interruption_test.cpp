// Runs that are stopped, killed, or meet another one in the same folder.
#include <csignal>

#include <chrono>
#include <thread>

#include "core/foundation/base/timer.h"
#include "tests/pipeline/sandbox.h"

namespace vitrine {
namespace {

const std::vector<std::string> kSlow = {"--set", "collect.repeat=40", "--set", "collect.step_ms=25", "-q"};

class Interruption : public Sandbox {
 protected:
  std::vector<std::string> slow_run() const {
    std::vector<std::string> words = {"run", photos().string(), "-o", out().string()};
    words.insert(words.end(), kSlow.begin(), kSlow.end());
    return words;
  }
  // Until the stage has written its first checkpoint; at most ten seconds.
  void wait_for_checkpoint() const {
    const Timer clock;
    while (clock.seconds() < 10) {
      for (const auto& e : ArtifactStore(store_of(out())).entries())
        if (fs::exists(e.path / "checkpoint.txt")) return;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    FAIL() << "the stage wrote no checkpoint";
  }
  void expect_nothing_finished() const {
    for (const auto& e : ArtifactStore(store_of(out())).entries()) EXPECT_FALSE(e.committed) << e.path;
  }
};

TEST_F(Interruption, EverySignalLeavesACheckpointAndARerunGivesTheSameBytes) {
  ASSERT_EQ(call(slow_run()).exit, 0);
  const auto whole = digests();
  for (const auto& [signal, code] :
       std::vector<std::pair<int, int>>{{SIGINT, 130}, {SIGTERM, 75}, {SIGUSR1, 75}, {SIGKILL, 128 + SIGKILL}}) {
    fs::remove_all(out());
    const pid_t child = start(slow_run());
    wait_for_checkpoint();
    kill(child, signal);
    EXPECT_EQ(wait_for(child), code);
    expect_nothing_finished();
    EXPECT_EQ(fs::exists(out() / "report.html"), signal != SIGKILL);
    if (signal != SIGKILL) {
      EXPECT_NE(read_file(out() / "report.html").find("<h1>It was stopped during collect.</h1>"), std::string::npos);
    }
    const Outcome rest = call({"run", out().string()});
    EXPECT_EQ(rest.exit, 0) << rest.text;
    EXPECT_NE(read_file(out() / "report.html").find("<h1>So far so good.</h1>"), std::string::npos);
    EXPECT_TRUE(rest.has("continuing at step")) << signal << "\n" << rest.text;
    EXPECT_EQ(digests(), whole) << signal;
  }
}

TEST_F(Interruption, AStageThatTakesTooMuchMemoryKeepsItsCheckpointAndSaysWhatToDo) {
  std::vector<std::string> words = slow_run();
  words.insert(words.end(), {"--set", "collect.memory_mb=300", "--max-memory", "150MiB"});
  const Outcome o = call(words);
  EXPECT_EQ(o.exit, 6) << o.text;
  EXPECT_TRUE(
      o.has("error: stage 'collect' needs more memory than it may take\n  where  --max-memory 150 MiB\n  why    it holds "))
      << o.text;
  EXPECT_TRUE(o.has("\n  try    a larger ")) << o.text;
  expect_nothing_finished();
  const Outcome rest = call({"run", out().string(), "--max-memory", "80%"});
  EXPECT_EQ(rest.exit, 0) << rest.text;
  EXPECT_TRUE(rest.has("continuing at step")) << rest.text;
}

TEST_F(Interruption, AStageThatIsKilledIsTakenUpAgain) {
  const pid_t child = start(slow_run());
  wait_for_checkpoint();
  // The stage's process: the only child of the pipeline.
  std::ifstream children(fmt::format("/proc/{0}/task/{0}/children", child));
  pid_t stage = 0;
  children >> stage;
  ASSERT_GT(stage, 0);
  kill(stage, SIGKILL);
  EXPECT_EQ(wait_for(child), 6);
  expect_nothing_finished();
  const Outcome rest = call({"run", out().string()});
  EXPECT_EQ(rest.exit, 0);
  EXPECT_TRUE(rest.has("continuing at step")) << rest.text;
}

// Before anything runs each stage is asked what it is: one that is killed meanwhile is not broken.
TEST_F(Interruption, AStageThatIsKilledWhileItDescribesItselfIsToldSo) {
  const fs::path stages = folder.path() / "stages";
  write_file(stages / "vitrine.stages", "collect\n");
  const fs::path program = stages / "vitrine-collect";
  setenv("VITRINE_STAGE_DIR", stages.c_str(), 1);
  for (const auto& [script, exit, message] :
       {std::tuple{"kill -9 $$", 6,
                   "error: stage 'collect' was killed\n  why    the system ends a process like this when memory"},
        {"kill -6 $$", 1, "error: stage 'collect' ended by signal 6 "},
        {"echo nonsense", 7, "error: the program of stage 'collect' does not describe itself"}}) {
    write_file(program, fmt::format("#!/bin/sh\n{}\n", script));
    fs::permissions(program, fs::perms::owner_all);
    const Outcome o = call({"run", photos().string(), "-o", out().string()});
    EXPECT_EQ(o.exit, exit) << o.text;
    EXPECT_TRUE(o.has(message)) << o.text;
    EXPECT_TRUE(o.has("\n  try    ")) << o.text;
  }
}

TEST_F(Interruption, ASecondRunInTheSameFolderIsRefused) {
  const pid_t child = start(slow_run());
  wait_for_checkpoint();
  const Outcome second = call(slow_run());
  EXPECT_EQ(second.exit, 9);
  EXPECT_TRUE(second.has("another run works in this folder")) << second.text;
  EXPECT_TRUE(second.has(fmt::format("it is process {} on ", child))) << second.text;
  EXPECT_EQ(call({"status", out().string()}).exit, 0);  // looking is allowed
  EXPECT_EQ(wait_for(child), 0);
  EXPECT_EQ(call(slow_run()).exit, 0);
}

TEST_F(Interruption, AStaleLockIsTakenOverWithANote) {
  const pid_t child = start(slow_run());
  wait_for_checkpoint();
  kill(child, SIGKILL);
  wait_for(child);
  const Outcome next = call({"run", out().string()});
  EXPECT_EQ(next.exit, 0);
  EXPECT_TRUE(next.has(fmt::format("taking over the folder from a run that was killed (process {} on ", child))) << next.text;
  EXPECT_FALSE(call({"run", out().string()}).has("taking over"));
}

}  // namespace
}  // namespace vitrine
