// Version guard: all stages and tools on sample_data/tiny_room, very small, against stage_digests.<release>.json: version, cache
// key and digest of the outputs of each. The same key with other bytes means that a stage changed and its version did not: caches
// would keep what the old program made. Its fix, and how the file is renewed, are in the messages.
//
// Digests are those of bytes (core/foundation/artifact/manifest.h: no time stamps, no seconds), the same for any number of
// processors; the renderer takes its AVX2 path everywhere. Other compilers and libraries round differently: each release of a
// distribution has a file, and with another compiler or C library than that file names the digests are not compared.
#include <gnu/libc-version.h>

#include <set>
#include <sstream>

#include "core/foundation/base/file.h"
#include "core/scene/image/exr.h"
#include "tests/e2e/tiny_room.h"
#include "tests/golden/golden.h"

namespace vitrine {
namespace {

const char* const kRenew = "VITRINE_RENEW_GOLDEN=1 build/bin/test_golden --gtest_filter='StageDigests.*'";
const char* const kVersions = "tests/golden/stage_versions.md";

// "debian-13": ID and VERSION_ID of an os-release file (freedesktop.org: os-release), which may stand in quotes; "" without one
// of them.
std::string release_name(const std::string& os_release) {
  const auto value = [&](const std::string& key) {
    for (const std::string& line : golden::lines_of(os_release))
      if (line.starts_with(key + "=")) return golden::replaced(line.substr(key.size() + 1), "\"", "");
    return std::string();
  };
  const std::string id = value("ID"), version = value("VERSION_ID");
  return id.empty() || version.empty() ? "" : id + "-" + version;
}

std::string this_release() {
  const fs::path file = "/etc/os-release";
  const std::string name = fs::exists(file) ? release_name(read_file(file)) : "";
  return name.empty() ? "unknown" : name;
}

// Below the root of the sources.
std::string digests_file() { return fmt::format("tests/golden/stage_digests.{}.json", this_release()); }

struct StageDigest {
  int version = 0;
  std::string key, digest;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StageDigest, version, key, digest)

struct DigestFile {
  std::map<std::string, std::string> made_with;  // compiler, libraries, maker of the processor: others round differently
  std::map<std::string, std::string> tools;      // "sfm.tool.colmap": parts of the keys that differ from machine to machine
  std::map<std::string, StageDigest> stages;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DigestFile, made_with, tools, stages)

// What is wrong with the digests of now, by those that are kept. `broken`: bytes moved under the same key.
struct Findings {
  std::vector<std::string> broken, outdated;
};

Findings compare(const DigestFile& kept, const DigestFile& now) {
  Findings f;
  for (const auto& [stage, is] : now.stages) {
    const auto was = kept.stages.find(stage);
    if (was == kept.stages.end())
      f.outdated.push_back(stage + ": new");
    else if (was->second.version != is.version)
      f.outdated.push_back(fmt::format("{}: version {} -> {}", stage, was->second.version, is.version));
    else if (was->second.key != is.key)
      f.outdated.push_back(fmt::format("{}: other inputs or options", stage));
    else if (was->second.digest != is.digest)
      f.broken.push_back(fmt::format(
          "stage '{0}' writes other bytes than before for the same inputs, options and version {1}: caches would keep the old "
          "ones.\n  If they are meant: raise .version in the StageInfo of stages/{0}/, add the line \"{2}. ...\" under \"{0}\" "
          "in {3}, "
          "then\n  {4}\n  If they are not: find the change.",
          stage, is.version, is.version + 1, kVersions, kRenew));
  }
  for (const auto& [stage, was] : kept.stages)
    if (!now.stages.contains(stage)) f.outdated.push_back(stage + ": gone");
  return f;
}

// "## mesh" and the number of the last line "9. ..." below it.
std::map<std::string, int> listed_versions(const std::string& page) {
  std::map<std::string, int> versions;
  std::istringstream lines(page);
  std::string stage;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("## ")) stage = line.substr(3);
    if (stage.empty() || line.empty() || !std::isdigit(static_cast<unsigned char>(line[0]))) continue;
    const int number = std::stoi(line);
    EXPECT_EQ(number, versions[stage] + 1) << kVersions << ": " << stage << " counts " << line;
    versions[stage] = number;
  }
  return versions;
}

class StageDigests : public TinyRoom {
 protected:
  // One instruction set on every machine: of our renderer, and of OpenCV's kernels, which are chosen at run time.
  StageDigests() { setenv("VITRINE_SIMD", "avx2", 1), setenv("OPENCV_CPU_DISABLE", "AVX512_SKX", 1); }
  ~StageDigests() override { unsetenv("VITRINE_SIMD"), unsetenv("OPENCV_CPU_DISABLE"); }

  void must(const Outcome& outcome) const { ASSERT_EQ(outcome.exit, 0) << outcome.text; }

  void run_everything() const {
    must(room(write_true_model(),
              {"--masks", (sample() / "truth/mask").string(), "--set", "optimize.iterations=24", "--set",
               "optimize.checkpoint_every=1000", "--set", "optimize.max_gaussians=1500", "--set", "refine.fine_tune.iterations=3",
               "--set", "mesh.faces=2000", "--set", "decompose.points=500", "--set", "evaluate.relit_samples=1"}));
    must(call({"render", out().string(), "--size", "48x32", "--layers"}));
    write_exr_rgb(folder.path() / "sky.exr", ImageF(16, 8, 3, 1.f));
    must(call({"relight", out().string(), "--env", (folder.path() / "sky.exr").string(), "--size", "24x16"}));
    write_file(folder.path() / "edits.yaml", "edits:\n  - name: all\n    select: all\n    set: {roughness: 0.5}\n");
    must(call({"edit", out().string(), (folder.path() / "edits.yaml").string()}));
    const ProcessResult r = run_process({.arguments = {std::string(VITRINE_BIN_DIR) + "/vitrine-inspect", "--input",
                                                       "photos=" + photos().string(), "--store", store_of(out()).string()}});
    ASSERT_TRUE(r.ok()) << r.tail;
  }

  // Approximate reciprocals, which Embree refines, are not the same numbers everywhere.
  static const char* maker() { return __builtin_cpu_is("intel") ? "Intel" : __builtin_cpu_is("amd") ? "AMD" : "another"; }

  DigestFile taken() const {
    DigestFile now;
    now.made_with = {
        {"compiler", __VERSION__}, {"libc", gnu_get_libc_version()}, {"build", VITRINE_BUILD_TYPE}, {"processor", maker()}};
    const ArtifactStore store(store_of(out()));
    for (const ArtifactStore::Entry& entry : store.entries()) {
      if (!entry.committed) continue;
      const auto manifest = store.find(entry.stage, entry.key);
      if (!manifest) continue;
      EXPECT_TRUE(now.stages.emplace(entry.stage, StageDigest{manifest->version, entry.key, manifest->content_digest}).second)
          << entry.stage << " ran twice";
      for (const auto& [term, value] : manifest->terms)
        if (term.starts_with("tool.")) now.tools[entry.stage + "." + term] = value;
    }
    return now;
  }
};

TEST_F(StageDigests, MoveOnlyWithTheVersion) {
  run_everything();
  if (HasFatalFailure()) return;
  const DigestFile now = taken();
  for (const char* stage : {"ingest", "optimize", "export", "render", "relight", "edit", "inspect"})
    EXPECT_TRUE(now.stages.contains(stage)) << stage << " has no artifact";

  const std::map<std::string, int> listed = listed_versions(read_file(fs::path(VITRINE_SOURCE_DIR) / kVersions));
  for (const auto& [stage, is] : now.stages) {
    const auto last = listed.find(stage);
    EXPECT_EQ(last == listed.end() ? 0 : last->second, is.version)
        << "stage '" << stage << "' has version " << is.version << ": add a line to its list in " << kVersions;
  }

  const fs::path file = fs::path(VITRINE_SOURCE_DIR) / digests_file();
  const bool exists = fs::exists(file);
  const DigestFile kept = exists ? nlohmann::json::parse(read_file(file)).get<DigestFile>() : DigestFile();
  const bool comparable = exists && kept.made_with == now.made_with;
  const Findings found = comparable ? compare(kept, now) : Findings();
  for (const std::string& text : found.broken) ADD_FAILURE() << text;
  if (std::getenv("VITRINE_RENEW_GOLDEN") != nullptr) {
    if (found.broken.empty()) write_file(file, nlohmann::json(now).dump(1) + "\n");
    return;
  }
  if (!exists)
    GTEST_SKIP() << "digests are not compared: there are none of " << this_release() << ". " << kRenew << " writes them to "
                 << digests_file();
  if (!comparable)
    GTEST_SKIP() << "digests are not compared: " << digests_file() << " is of " << nlohmann::json(kept.made_with).dump()
                 << ", this is " << nlohmann::json(now.made_with).dump();
  // Where a stage is broken, those after it have other inputs; with other tools, keys are others.
  if (found.broken.empty() && !found.outdated.empty() && kept.tools == now.tools)
    ADD_FAILURE() << digests_file() << " is of an earlier state (" << fmt::format("{}", fmt::join(found.outdated, "; "))
                  << "):\n  " << kRenew;
}

TEST(StageDigestsRule, EachReleaseOfADistributionHasItsFile) {
  EXPECT_EQ(release_name("PRETTY_NAME=\"Debian GNU/Linux 13 (trixie)\"\nVERSION_ID=\"13\"\nID=debian\n"), "debian-13");
  EXPECT_EQ(release_name("ID=ubuntu\nID_LIKE=debian\nVERSION_ID=24.04\n"), "ubuntu-24.04");
  EXPECT_EQ(release_name("ID=arch\nBUILD_ID=rolling\n"), "");
  EXPECT_TRUE(digests_file().ends_with("stage_digests." + this_release() + ".json"));
}

TEST(StageDigestsRule, TellsAChangeWithoutAVersionFromOthers) {
  const DigestFile kept{{}, {}, {{"mesh", {9, "k", "d"}}, {"export", {8, "k", "d"}}}};
  const auto found = [&](const StageDigest& mesh) {
    return compare(kept, {{}, {}, {{"mesh", mesh}, {"export", {8, "k", "d"}}}});
  };
  EXPECT_TRUE(found({9, "k", "d"}).broken.empty() && found({9, "k", "d"}).outdated.empty());
  const Findings moved = found({9, "k", "other"});
  ASSERT_EQ(moved.broken.size(), 1u);
  for (const char* part : {"raise .version", "stages/mesh/", "\"10. ...\"", "stage_versions.md", "VITRINE_RENEW_GOLDEN=1"})
    EXPECT_NE(moved.broken[0].find(part), std::string::npos) << moved.broken[0];
  EXPECT_EQ(found({10, "k2", "other"}).outdated, (std::vector<std::string>{"mesh: version 9 -> 10"}));
  EXPECT_EQ(found({9, "k2", "other"}).outdated, (std::vector<std::string>{"mesh: other inputs or options"}));
  EXPECT_TRUE(found({9, "k2", "other"}).broken.empty());
  EXPECT_EQ(compare(kept, {{}, {}, {{"mesh", {9, "k", "d"}}}}).outdated, (std::vector<std::string>{"export: gone"}));
}

}  // namespace
}  // namespace vitrine
