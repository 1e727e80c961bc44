// Runs that are killed (SIGKILL) at random moments, program and stages alike: the same command again ends with the same bytes.
// How often: VITRINE_KILLS (2); which moments: VITRINE_KILL_SEED (1); begin no other run after VITRINE_KILL_SECONDS (none).
#include <csignal>

#include <chrono>
#include <limits>
#include <set>
#include <thread>

#include "core/foundation/base/rng.h"
#include "core/foundation/base/timer.h"
#include "tests/e2e/tiny_room.h"

namespace vitrine {
namespace {

// Photos of half the size: what is killed is the order of the stages, their checkpoints and their files.
const std::vector<std::string> kSmoke = {"--set", "ingest.max_side=48"};

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
  // "optimize" for the process of vitrine-optimize; "plan" when there is none, or one that only says its key.
  static std::string name_of(pid_t stage) {
    std::ifstream file(fmt::format("/proc/{}/cmdline", stage));
    const std::string words{std::istreambuf_iterator<char>(file), {}};
    const std::string program = fs::path(words.substr(0, words.find('\0'))).filename().string();
    const bool plans = words.find("--print-key") != std::string::npos || words.find("--describe") != std::string::npos;
    return plans || !program.starts_with("vitrine-") ? "plan" : program.substr(8);
  }
  // Stages of the output folder's runs so far, in the order in which they began.
  std::vector<std::string> begun() const {
    std::vector<std::string> stages;
    std::error_code ec;
    if (!fs::exists(out() / "events.jsonl", ec)) return stages;
    std::istringstream lines(read_file(out() / "events.jsonl"));
    for (std::string line; std::getline(lines, line);) {
      const auto event = nlohmann::json::parse(line, nullptr, false);
      if (event.is_object() && event.value("type", "") == "stage_start") stages.push_back(event.at("stage"));
    }
    return stages;
  }
};

constexpr size_t kStages = 11;
// The page that a run ends with, where the build had npm.
const size_t kPages = fs::exists(fs::path(VITRINE_BIN_DIR) / "vitrine-view.html") ? 1 : 0;

// A run is killed up to five times, each time taken up by the same command at the place where it was; then it is let to its end.
// The first kill waits for a stage, another one in every run: otherwise the slowest would meet them all.
TEST_F(KilledRuns, GoOnToTheSameBytes) {
  constexpr uint64_t kMostKillsOfARun = 5;
  const uint64_t kills = number_from("VITRINE_KILLS", 2), seed = number_from("VITRINE_KILL_SEED", 1);
  const uint64_t most_s = number_from("VITRINE_KILL_SECONDS", std::numeric_limits<uint64_t>::max());
  const Timer clock;
  ASSERT_EQ(room(true_poses(), kSmoke).exit, 0);
  const double whole_s = clock.seconds();
  const auto whole = digests();
  ASSERT_EQ(whole.size(), kStages + kPages);
  std::vector<std::string> words = room_words(true_poses(), kSmoke);
  words.push_back("-q");
  uint64_t killed = 0, recovered = 0, runs = 0;
  std::map<std::string, uint64_t> met;  // stage -> kills
  for (uint64_t moment = 0; killed < kills && clock.seconds() < double(most_s);) {
    fs::remove_all(out());
    ++runs;
    uint64_t now = 0;
    std::string story;
    for (bool done = false; !done && now < kMostKillsOfARun && killed + now < kills; ++moment) {
      const pid_t child = start(words);
      const std::string from = std::next(whole.begin(), std::ptrdiff_t((seed + runs) % whole.size()))->first;
      const auto there = [&] {
        const auto stages = begun();
        return now > 0 || std::find(stages.begin(), stages.end(), from) != stages.end();
      };
      for (const Timer patience; !there() && patience.seconds() < 60 + 10 * whole_s;)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      const double after_s = 0.2 * whole_s * Rng(seed, moment).uniform_double();
      std::this_thread::sleep_for(std::chrono::duration<double>(after_s));
      // Every third time the stage alone, every third time the program alone.
      const pid_t stage = stage_of(child);
      const std::string name = name_of(stage);
      if (moment % 3 != 0 && stage > 0) kill(stage, SIGKILL);
      if (moment % 3 != 1 || stage <= 0) kill(child, SIGKILL);
      done = wait_for(child) == 0;
      if (done) break;
      ++now;
      ++met[name];
      story += fmt::format("  kill {} of {} after {:.2f} s\n", moment, name, after_s);
    }
    const Outcome rest = room(true_poses(), kSmoke);
    const bool equal = rest.exit == 0 && digests() == whole;
    EXPECT_TRUE(equal) << story << rest.text;
    killed += now;
    if (equal) recovered += now;
  }
  std::string where;
  for (const auto& [name, count] : met) where += fmt::format("  {} {}", count, name);
  fmt::print("{} of {} kills recovered to equal digests, in {} runs; {} were asked for\n{}\n", recovered, killed, runs, kills,
             where);
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
      for (const std::string& name : begun())
        if (!killed.contains(name)) return name;
      return {};
    };
    int status = 0;
    std::string met;
    while ((met = new_stage()).empty() && waitpid(child, &status, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (met.empty()) break;  // done: the stages that are left compute nothing that could be met
    killed.insert(met);
    if (const pid_t worker = stage_of(child); worker > 0) kill(worker, SIGKILL);
    kill(child, SIGKILL);
    wait_for(child);
  }
  EXPECT_EQ(killed.size() + kPages, whole.size()) << "the page is no stage of the run's events: it follows the run";
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
