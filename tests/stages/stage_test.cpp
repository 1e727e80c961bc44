// stage_main through real executables (tests/pipeline/stages).
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include <gtest/gtest.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "stages/stage_cli.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using nlohmann::json;

struct Outcome {
  int exit = -1;
  std::string text;
};

Outcome call(const std::string& stage, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), std::string(VITRINE_TEST_STAGE_DIR) + "/vitrine-" + stage);
  Outcome out;
  const ProcessResult r =
      run_process({.arguments = arguments, .on_line = [&](std::string_view line) { out.text += std::string(line) + "\n"; }});
  out.exit = r.signal != 0 ? 128 + r.signal : r.exit_code;
  return out;
}

class StageMain : public testing::Test {
 protected:
  StageMain() {
    write_file(photos() / "ä 1.jpg", "one");
    write_file(photos() / "b.jpg", "three");
  }
  fs::path photos() const { return folder.path() / "my photos"; }
  fs::path out() const { return folder.path() / "out ö"; }
  Outcome collect(std::vector<std::string> more) const {
    more.insert(more.begin(), {"--input", "photos=" + photos().string(), "--output", out().string()});
    return call("collect", more);
  }
  std::string key(std::vector<std::string> more) const {
    more.push_back("--print-key");
    return json::parse(collect(more).text).at("key").get<std::string>();
  }
  TemporaryFolder folder;
};

TEST_F(StageMain, ComputesOnceAndLinksTheFilesOut) {
  const Outcome first = collect({});
  EXPECT_EQ(first.exit, 0) << first.text;
  EXPECT_EQ(read_file(out() / "collect/list.txt"), "\nb.jpg 5\nä 1.jpg 3\n");
  const Outcome second = collect({});
  EXPECT_EQ(second.exit, 0);
  EXPECT_NE(second.text.find("up to date"), std::string::npos) << second.text;
  ArtifactStore store(out() / ".cache");
  ASSERT_EQ(store.entries().size(), 1u);  // no scratch folder, no temporary folder left
  const auto manifest = store.find("collect", store.entries()[0].key);
  EXPECT_EQ(manifest->metrics.at("files"), 2);
  EXPECT_EQ(manifest->terms.at("version"), "2");
  EXPECT_EQ(manifest->terms.at("tool.lister"), "1.0");
  EXPECT_EQ(manifest->terms.count("option.step_ms"), 0u);
}

TEST_F(StageMain, KeyDependsOnWhatChangesTheResultAndOnNothingElse) {
  const std::string plain = key({});
  EXPECT_EQ(key({"--set", "step_ms=1", "-j", "1", "--max_memory=1GiB"}), plain);
  EXPECT_NE(key({"--set", "repeat=2"}), plain);
  const fs::path moved = folder.path() / "moved";
  fs::rename(photos(), moved);
  fs::create_directory_symlink(moved, photos());
  fs::last_write_time(moved / "b.jpg", fs::file_time_type::clock::now() - std::chrono::hours(3));
  EXPECT_EQ(key({}), plain);
  write_file(moved / "b.jpg", "three!");
  EXPECT_NE(key({}), plain);
}

TEST_F(StageMain, FileOfAnOptionCountsForTheKeyByItsContent) {
  const fs::path foot = folder.path() / "foot.txt", other = folder.path() / "other.txt";
  const auto with = [&](const fs::path& file) { return key({"--set", "foot=" + file.string()}); };
  const std::string missing = with(foot);
  write_file(foot, "1 May\n");
  write_file(other, "1 May\n");
  const std::string before = with(foot);
  EXPECT_NE(before, key({}));
  EXPECT_NE(before, missing);
  EXPECT_EQ(with(other), before);
  write_file(foot, "2 May\n");
  EXPECT_NE(with(foot), before);
}

TEST_F(StageMain, FilesThatAGivenFileRefersToCountForTheKey) {
  const StageInfo info{.name = "any",
                       .inputs = {{.name = "list", .artifact = false, .also = [](const fs::path& list) {
                                     return std::vector<fs::path>{list.parent_path() / "my photos/b.jpg"};
                                   }}}};
  write_file(folder.path() / "list.json", "my photos/b.jpg");
  DigestCache digests(folder.path() / "digests");
  const auto digest = [&] {
    return resolve_inputs(info, {"list=" + (folder.path() / "list.json").string()}, digests).at("list").content_digest;
  };
  const std::string before = digest();
  EXPECT_EQ(digest(), before);
  write_file(photos() / "b.jpg", "other");
  EXPECT_NE(digest(), before);
}

TEST_F(StageMain, DamageIsNoticedAndRepaired) {
  ASSERT_EQ(collect({}).exit, 0);
  std::ofstream(out() / "collect/list.txt") << "edited in place";
  const Outcome again = collect({});
  EXPECT_EQ(again.exit, 0);
  EXPECT_NE(again.text.find("is damaged (collect/list.txt has 15 bytes instead of"), std::string::npos) << again.text;
  EXPECT_EQ(read_file(out() / "collect/list.txt"), "\nb.jpg 5\nä 1.jpg 3\n");
}

TEST_F(StageMain, EveryKindOfFailureHasItsExitCodeAndLeavesNothing) {
  const std::vector<std::pair<std::string, int>> cases = {
      {"input", 4}, {"memory", 6}, {"exception", 1}, {"check", 1}, {"crash", 128 + SIGKILL}};
  for (const auto& [how, code] : cases) {
    EXPECT_EQ(collect({"--set", "fail=" + how}).exit, code) << how;
    for (const auto& e : ArtifactStore(out() / ".cache").entries()) EXPECT_FALSE(e.committed) << how;
  }
  EXPECT_FALSE(fs::exists(out() / "collect"));
  EXPECT_EQ(collect({"--set", "fail=input"}).text,
            "error: 9 of 52 images have poses\n  where  photos\n  why    no texture\n  try    more photos\n");
  EXPECT_EQ(collect({}).exit, 0);
  EXPECT_EQ(ArtifactStore(out() / ".cache").entries().size(), 1u);
}

TEST_F(StageMain, UsageErrorsSayWhatToWrite) {
  const Outcome flag = collect({"--thread", "2"});
  EXPECT_EQ(flag.exit, 2);
  EXPECT_EQ(flag.text, "error: unknown flag --thread; did you mean --threads?\n  try    vitrine-collect --help\n");
  EXPECT_EQ(collect({"--set", "repeet=2"}).text,
            "--set: error: unknown key 'repeet'; did you mean 'repeat'?\n1 error\n  try    vitrine-collect --help lists "
            "every option\n");
  EXPECT_EQ(collect({"--set", "label=forbidden"}).exit, 2);
  EXPECT_EQ(collect({"-j", "many"}).exit, 2);
  EXPECT_EQ(collect({"--max-memory", "4 apples"}).exit, 2);
  EXPECT_EQ(collect({"stray"}).exit, 2);
  EXPECT_EQ(collect({"--set"}).exit, 2);
  EXPECT_EQ(call("collect", {"--input", "photos=" + photos().string()}).exit, 2);
  EXPECT_EQ(call("collect", {"--output", out().string()}).exit, 2);
  EXPECT_EQ(call("collect", {"--input", "photo=x", "--output", out().string()}).exit, 2);
  EXPECT_EQ(call("collect", {"--input", "photos=/nowhere", "--output", out().string()}).exit, 3);
  EXPECT_EQ(call("collect", {"--input", "photos=" + photos().string(), "--output", "/proc/nowhere"}).exit, 6);
}

TEST_F(StageMain, WritesNothingIntoWhatItReads) {
  fs::create_directory_symlink(photos(), folder.path() / "link");
  for (const fs::path& place : {photos() / "out", photos(), folder.path() / "link/out"}) {
    const Outcome o = call("collect", {"--input", "photos=" + photos().string(), "--output", place.string()});
    EXPECT_EQ(o.exit, 2) << place;
    EXPECT_NE(o.text.find("inside the folder of photos"), std::string::npos) << o.text;
  }
  EXPECT_FALSE(fs::exists(photos() / "out"));
}

TEST_F(StageMain, ReadsConfigFilesFlatOrByStage) {
  const fs::path flat = folder.path() / "flat.yaml", whole = folder.path() / "whole.yaml", wrong = folder.path() / "wrong.yaml";
  write_file(flat, "label: flat\nrepeat: 2\n");
  write_file(whole, "collect:\n  label: whole\nother:\n  x: 1\n");
  write_file(wrong, "lable: x\n");
  EXPECT_EQ(collect({"-c", flat.string(), "-c", whole.string(), "--set", "repeat=1"}).exit, 0);
  EXPECT_EQ(read_file(out() / "collect/list.txt"), "whole\nb.jpg 5\nä 1.jpg 3\n");
  const Outcome bad = collect({"-c", wrong.string()});
  EXPECT_EQ(bad.exit, 2);
  EXPECT_NE(bad.text.find("wrong.yaml:1:1: error: unknown key 'lable'; did you mean 'label'?"), std::string::npos) << bad.text;
}

TEST_F(StageMain, EventsTellTheWholeRun) {
  const fs::path events = folder.path() / "events.jsonl";
  ASSERT_EQ(collect({"--events", events.string(), "--set", "repeat=3"}).exit, 0);
  std::istringstream lines(read_file(events));
  std::vector<std::string> types;
  for (std::string line; std::getline(lines, line);) {
    const json e = json::parse(line);
    EXPECT_EQ(e.at("v"), kEventsVersion);
    EXPECT_EQ(e.at("stage"), "collect");
    types.push_back(e.at("type"));
    if (types.back() == "stage_end") {
      EXPECT_EQ(e.at("summary"), "2 files");
      EXPECT_EQ(e.at("metrics").at("files"), 2);
      EXPECT_FALSE(e.at("cached").get<bool>());
    }
  }
  EXPECT_EQ(types.front(), "stage_start");
  EXPECT_EQ(types.back(), "stage_end");
  EXPECT_NE(std::find(types.begin(), types.end(), "progress"), types.end());
  EXPECT_NE(std::find(types.begin(), types.end(), "timing"), types.end());
}

TEST_F(StageMain, TakesArtifactsOfAStoreAndRefusesOthers) {
  ASSERT_EQ(collect({}).exit, 0);
  const fs::path entry = ArtifactStore(out() / ".cache").entries()[0].path, second = folder.path() / "second";
  EXPECT_EQ(call("upper", {"--input", "collect=" + entry.string(), "--output", second.string()}).exit, 0);
  EXPECT_EQ(read_file(second / "upper/list.txt"), "\nB.JPG 5\nä 1.JPG 3\nnone");
  const fs::path upper = ArtifactStore(second / ".cache").entries()[0].path;
  EXPECT_EQ(call("upper", {"--input", "collect=" + upper.string(), "--output", second.string()}).exit, 3);
  std::ofstream(entry / "collect/list.txt") << "damaged";
  const Outcome damaged = call("upper", {"--input", "collect=" + entry.string(), "--output", second.string()});
  EXPECT_EQ(damaged.exit, 3);
  EXPECT_NE(damaged.text.find("the artifact of stage 'collect' is damaged"), std::string::npos);
}

TEST_F(StageMain, StopsOnInterruptAndContinuesToTheSameBytes) {
  ASSERT_EQ(collect({"--set", "repeat=40", "--set", "step_ms=20"}).exit, 0);
  const std::string whole = read_file(out() / "collect/list.txt");
  for (int signal : {SIGINT, SIGTERM, SIGKILL}) {
    fs::remove_all(out());
    const std::vector<std::string> words = {std::string(VITRINE_TEST_STAGE_DIR) + "/vitrine-collect",
                                            "--input",
                                            "photos=" + photos().string(),
                                            "--output",
                                            out().string(),
                                            "--set",
                                            "repeat=40",
                                            "--set",
                                            "step_ms=20",
                                            "-q"};
    const pid_t child = fork();
    if (child == 0) {
      std::vector<char*> argv;
      for (const std::string& w : words) argv.push_back(const_cast<char*>(w.c_str()));
      argv.push_back(nullptr);
      execv(argv[0], argv.data());
      _exit(99);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    kill(child, signal);
    int status = 0;
    waitpid(child, &status, 0);
    if (signal != SIGKILL) {
      EXPECT_EQ(WEXITSTATUS(status), signal == SIGINT ? 130 : 75);
    }
    for (const auto& e : ArtifactStore(out() / ".cache").entries()) EXPECT_FALSE(e.committed);
    const Outcome rest = collect({"--set", "repeat=40", "--set", "step_ms=20"});
    EXPECT_EQ(rest.exit, 0) << rest.text;
    EXPECT_NE(rest.text.find("continuing at step"), std::string::npos) << signal << rest.text;
    EXPECT_EQ(read_file(out() / "collect/list.txt"), whole);
  }
}

struct OneOption {
  int points = 3;
};
void describe(Describer& d, OneOption& c) { d.option("points", c.points, "Points of the surface.").range(1, 100); }

// What vitrine-STAGE makes of a file: the value, or the complaint.
std::string points_from(const StageInfo& info, const std::string& yaml) {
  const TemporaryFolder folder;
  write_file(folder.path() / "options.yaml", yaml);
  OneOption config;
  OptionTable options = options_of(config);
  StageArguments arguments;
  arguments.configs = {(folder.path() / "options.yaml").string()};
  try {
    apply_stage_config(arguments, info, options);
  } catch (const Error& e) {
    return e.message();
  }
  return std::to_string(config.points);
}

TEST(StageFile, IsItsSectionOrTheWholeFile) {
  const StageInfo info{.name = "decompose", .summary = "s", .inputs = {}};
  EXPECT_EQ(points_from(info, "mesh:\n  x: 1\ndecompose:\n  points: 8\n"), "8");
  EXPECT_EQ(points_from(info, "points: 9\n"), "9");
}

TEST_F(StageMain, DescribesItself) {
  const json d = json::parse(call("collect", {"--describe"}).text);
  EXPECT_EQ(d.at("name"), "collect");
  EXPECT_EQ(d.at("version"), 2);
  EXPECT_EQ(d.at("inputs").size(), 2u);
  EXPECT_TRUE(d.at("inputs")[1].at("optional").get<bool>());
  EXPECT_EQ(d.at("options")[0].at("high"), 100000);
  const std::string help = call("collect", {"--help"}).text;
  EXPECT_NE(help.find("usage: vitrine-collect --input NAME=PATH... --output DIR [options]"), std::string::npos);
  for (const char* word : {"--print-key", "--max-memory", "notes (optional)",
                           "repeat: an integer between 1 and 100000, default 1", "-j, --threads N"})
    EXPECT_NE(help.find(word), std::string::npos) << word;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
}

}  // namespace
}  // namespace vitrine
