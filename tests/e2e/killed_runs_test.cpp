// Runs that are killed (SIGKILL) at random moments, program and stages alike: the same command again ends with the same bytes.
// How often: VITRINE_KILLS (2); which moments: VITRINE_KILL_SEED (1).
#include <csignal>

#include <chrono>
#include <set>
#include <thread>

#include "core/base/rng.h"
#include "core/base/timer.h"
#include "tests/e2e/tiny_room.h"

namespace vitrine {
namespace {

// Every stage computes something, none for long.
const std::vector<std::string> kSmoke = {"--set", "optimize.iterations=60",     "--set", "optimize.checkpoint_every=10",
                                         "--set", "mesh.resolution=32",         "--set", "optimize.max_gaussians=3000",
                                         "--set", "relight.points=1000",        "--set", "optimize.initial.stereo_side=48",
                                         "--set", "masks.proposed.fit.steps=60", "--set", "normals.geometric.max_side=48"};

class KilledRuns : public TinyRoom {
 protected:
  static uint64_t number_from(const char* name, uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
  }
  // The program that does the work now: the child of `vitrine`.
  static pid_t stage_of(pid_t vitrine) {
    std::ifstream children(fmt::format("/proc/{0}/task/{0}/children", vitrine));
    pid_t stage = 0;
    children >> stage;
    return stage;
  }
};

TEST_F(KilledRuns, GoOnToTheSameBytes) {
  const uint64_t kills = number_from("VITRINE_KILLS", 2), seed = number_from("VITRINE_KILL_SEED", 1);
  const Timer clock;
  ASSERT_EQ(room(true_poses(), kSmoke).exit, 0);
  const double whole_s = clock.seconds();
  const auto whole = digests();
  ASSERT_GE(whole.size(), 5u);
  uint64_t recovered = 0, hit = 0;
  for (uint64_t i = 0; i < kills; ++i) {
    fs::remove_all(out());
    Rng rng(seed, i);
    std::vector<std::string> words = room_words(true_poses(), kSmoke);
    words.push_back("-q");
    const pid_t child = start(words);
    const double moment_s = whole_s * rng.uniform_double();
    std::this_thread::sleep_for(std::chrono::duration<double>(moment_s));
    // Every third time the stage alone, every third time both.
    const pid_t stage = stage_of(child);
    if (i % 3 != 0 && stage > 0) kill(stage, SIGKILL);
    if (i % 3 != 1 || stage <= 0) kill(child, SIGKILL);
    hit += wait_for(child) != 0;
    const Outcome again = room(true_poses(), kSmoke);
    EXPECT_EQ(again.exit, 0) << "kill " << i << " after " << moment_s << " s\n" << again.text;
    EXPECT_EQ(digests(), whole) << "kill " << i << " after " << moment_s << " s";
    recovered += again.exit == 0 && digests() == whole;
    if (again.exit == 9) kill(stage, SIGKILL);
  }
  fmt::print("{} of {} kills recovered to equal digests, {} of them met a run that was not yet done\n", recovered, kills, hit);
}

// One run, killed once in every stage that computes something, and taken up again each time.
TEST_F(KilledRuns, OnceInEveryStage) {
  ASSERT_EQ(room(true_poses(), kSmoke).exit, 0);
  const auto whole = digests();
  fs::remove_all(out());
  std::vector<std::string> words = room_words(true_poses(), kSmoke);
  words.push_back("-q");
  std::set<std::string> killed;
  for (const auto& [stage, digest] : whole) {
    static_cast<void>(digest);
    const pid_t child = start(words);
    // Until a stage begins that was not killed yet, or the run is done.
    const auto new_stage = [&]() -> std::string {
      std::error_code ec;
      if (!fs::exists(out() / "events.jsonl", ec)) return {};
      std::istringstream lines(read_file(out() / "events.jsonl"));
      for (std::string line; std::getline(lines, line);) {
        const auto event = nlohmann::json::parse(line, nullptr, false);
        if (event.is_object() && event.value("type", "") == "stage_start" && !killed.contains(event.value("stage", "")))
          return event.at("stage");
      }
      return {};
    };
    int status = 0;
    std::string begun;
    while ((begun = new_stage()).empty() && waitpid(child, &status, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (begun.empty()) break;  // done: the stages that are left compute nothing that could be met
    killed.insert(begun);
    if (const pid_t worker = stage_of(child); worker > 0) kill(worker, SIGKILL);
    kill(child, SIGKILL);
    wait_for(child);
  }
  EXPECT_EQ(killed.size(), whole.size());
  EXPECT_EQ(room(true_poses(), kSmoke).exit, 0);
  EXPECT_EQ(digests(), whole);
}

TEST_F(KilledRuns, PhotosThatCannotBeWrittenToAreNotTouched) {
  // Permissions hold back no root: what counts is what lies there afterwards.
  const auto all = [&] {
    std::map<std::string, std::pair<std::string, fs::file_time_type>> files;
    for (const auto& e : fs::recursive_directory_iterator(photos()))
      if (e.is_regular_file()) files[e.path().string()] = {read_file(e.path()), e.last_write_time()};
    return files;
  };
  for (const auto& e : fs::directory_iterator(photos())) fs::permissions(e.path(), fs::perms::owner_read);
  fs::permissions(photos(), fs::perms::owner_read | fs::perms::owner_exec);
  const auto before = all();
  const Outcome o = room(true_poses(), kSmoke);
  const auto after = all();
  fs::permissions(photos(), fs::perms::owner_all);
  EXPECT_EQ(o.exit, 0) << o.text;
  EXPECT_EQ(before.size(), 12u);
  EXPECT_TRUE(after == before);
}

}  // namespace
}  // namespace vitrine
