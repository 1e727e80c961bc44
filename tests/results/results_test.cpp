// The table of README.md is that of tests/results/*.json, and a finished run is recorded as it was.
#include "tests/results/results.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "tests/results/optics_table.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

const fs::path kSources = VITRINE_SOURCE_DIR;
const RunLabel kLabel{"two boxes", "0123456789abcdef", "a processor", 2};

TEST(Results, TableOfTheReadmeIsThatOfTheFiles) {
  const std::string page = read_file(kSources / "README.md");
  EXPECT_EQ(page, with_table(page, results_table(kSources / "tests/results"))) << "run: build/bin/vitrine-results table";
}

TEST(Results, AreOneToEight) {
  const auto files =
      std::count_if(fs::directory_iterator(kSources / "tests/results"), fs::directory_iterator(),
                    [](const auto& e) { return e.path().extension() == ".json" && e.path().filename() != kOpticsFile; });
  EXPECT_GE(files, 1);
  EXPECT_LE(files, 8);
}

TEST(Results, NameACommitAndNoFolderOfAMachine) {
  for (const auto& e : fs::directory_iterator(kSources / "tests/results")) {
    if (e.path().extension() != ".json") continue;
    const nlohmann::json r = nlohmann::json::parse(read_file(e.path()));
    const std::string commit = r.at("commit"), command = r.value("command", "");
    EXPECT_EQ(commit.size(), 40u) << e.path();
    EXPECT_EQ(commit.find_first_not_of("0123456789abcdef"), std::string::npos) << e.path();
    EXPECT_EQ(command.empty(), e.path().filename() == kOpticsFile) << e.path();
    EXPECT_EQ(read_file(e.path()).find(" /"), std::string::npos) << e.path();
    EXPECT_EQ(read_file(e.path()).find("\"/"), std::string::npos) << e.path();
    // Scenes of optics.json may be captures, which have no seed.
    EXPECT_FALSE(r.at(e.path().filename() == kOpticsFile ? "training_seeds" : "seeds").empty()) << e.path();
  }
}

class RecordedRun : public testing::Test {
 protected:
  void write(const std::string& stage_state, const std::string& metrics) const {
    write_file(folder.path() / "run.json",
               R"({"command": ["vitrine", "run", "/home/me/vitrine/sample_data/boxes/photos", "-o", "/home/me/boxes", "--masks",
                   "/home/me/marks.yaml"], "finished": "2031-02-03T04:05:06Z", "seconds": 61.4, "exit": 0, "peak_rss_bytes": 5,
                   "machine": {"host": "here", "threads": 2},
                   "stages": [{"name": "ingest", "state": "ran", "cpu_seconds": 59.8},
                              {"name": "sfm", "cpu_seconds": 60.4, "state": ")" +
                   stage_state + "\"}]}");
    write_file(folder.path() / "config.resolved.yaml",
               "preset: preview\ninput:\n  photos: /home/me/vitrine/sample_data/boxes/photos\noptimize:\n  seed: 7\n");
    make_folders(folder.path() / "eval");
    write_file(folder.path() / "eval/metrics.json", metrics);
  }
  TemporaryFolder folder;
};

constexpr const char* kMetrics =
    R"({"heldout": {"psnr": 21.63687375, "ssim": 0.73587872, "views": 2}, "regions": {"rest": {"psnr": 20.25}}, "surfels": 3912})";

TEST_F(RecordedRun, HoldsFiguresSeedsAndTimes) {
  write("ran", kMetrics);
  const nlohmann::json r = nlohmann::json::parse(recorded_run(folder.path(), kLabel));
  EXPECT_EQ(r.at("command"), "vitrine run sample_data/boxes/photos -o out --masks marks.yaml");
  EXPECT_EQ(r.at("scene"), "sample_data/boxes/photos");
  EXPECT_EQ(r.at("preset"), "preview");
  EXPECT_EQ(r.at("seeds"), nlohmann::json::array({7}));
  EXPECT_EQ(r.at("date"), "2031-02-03");
  EXPECT_EQ(r.at("seconds"), 61);
  EXPECT_EQ(r.at("cpu_seconds"), 120);
  EXPECT_EQ(r.at("machine").at("cpu"), "a processor");
  EXPECT_EQ(r.at("figures"), nlohmann::json({{"heldout.psnr", 21.6369},
                                             {"heldout.ssim", 0.735879},
                                             {"heldout.views", 2},
                                             {"regions.rest.psnr", 20.25},
                                             {"surfels", 3912}}));
}

TEST_F(RecordedRun, IsARowWithEmptyCellsForFiguresThatAreAbsent) {
  write("ran", kMetrics);
  write_file(folder.path() / "rows/boxes.json", recorded_run(folder.path(), kLabel));
  EXPECT_NE(
      results_table(folder.path() / "rows")
          .find("| two boxes | 21.6 | 0.736 |  |  | 20.2 |  |  |  |  | 2 min | `0123456` |\n\nMachines: a processor, 2 cores.\n"),
      std::string::npos)
      << results_table(folder.path() / "rows");
}

TEST_F(RecordedRun, IsRefusedWhenAStageWasTakenFromTheStoreOrNothingWasMeasured) {
  write("cached", kMetrics);
  EXPECT_THROW(recorded_run(folder.path(), kLabel), Error);
  write("ran", "{}");
  EXPECT_THROW(recorded_run(folder.path(), kLabel), Error);
}

constexpr const char* kOptics =
    R"({"format": "vitrine-optics 1", "commit": "fedcba9876543210", "machine": {"cpu": "a processor", "cores": 2},
        "seeds": [1, 2, 3], "training_seeds": [1, 2], "settings": {"steps": 1000}, "scenes": [{}, {}, {}], "against": "diffuse",
        "gains": [{"arm": "full", "figures": {"all": {"mean": 0.45, "deviation": 0.21, "worst": 0.2, "scenes": 3},
                                              "coated_pooled": {"mean": -1.26, "deviation": 0, "worst": -1.26, "scenes": 1},
                                              "normals_mirror": {"mean": -8.4, "deviation": 2.6, "worst": -5, "scenes": 2}}}]})";

TEST_F(RecordedRun, DifferencesOverScenesAreATableOfTheirOwnBehindTheRows) {
  write("ran", kMetrics);
  write_file(folder.path() / "rows/boxes.json", recorded_run(folder.path(), kLabel));
  const std::string rows = results_table(folder.path() / "rows");
  write_file(folder.path() / "rows/optics.json", kOptics);
  const std::string both = results_table(folder.path() / "rows");
  const std::string table =
      "\n| minus `diffuse`, 3 scenes x 2 seeds, `fedcba9` | PSNR | glass | mirrors | coats | rest | behind glass | relit | "
      "normals: "
      "glass | mirrors | coats |\n|---|---|---|---|---|---|---|---|---|---|---|\n"
      "| full | +0.5 ± 0.2 |  |  | -1.3 |  |  |  |  | -8 ± 3 |  |\n";
  const size_t at = both.find(table);
  ASSERT_NE(at, std::string::npos) << both;
  EXPECT_EQ(std::string(both).erase(at, table.size()), rows);
}

TEST(OpticsTable, IsRefusedWithoutAnEntryOrOfAnotherFormat) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / kOpticsFile;
  for (const char* entry : {"gains", "against", "commit", "format"}) {
    auto document = nlohmann::json::parse(kOptics);
    document.erase(entry);
    write_file(file, document.dump());
    const Error e = error_of([&] { optics_table(file); });
    EXPECT_EQ(e.detail().where, file.string()) << entry;
    EXPECT_NE(e.message().find(entry), std::string::npos) << e.what();
  }
}

TEST(Results, PageWithoutMarksIsRefused) {
  EXPECT_THROW(with_table("<!-- end of results -->\n", "x"), Error);
  EXPECT_EQ(with_table("a\n<!-- results: written by `vitrine-results table` -->\nold\n<!-- end of results -->\nb\n", "new\n"),
            "a\n<!-- results: written by `vitrine-results table` -->\nnew\n<!-- end of results -->\nb\n");
}

}  // namespace
}  // namespace vitrine
