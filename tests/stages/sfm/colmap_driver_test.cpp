// The driver against programs that answer like six versions of COLMAP, like nothing, and like something else.
#include "stages/sfm/colmap_driver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "core/foundation/base/error.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

struct FakeVersion {
  const char *first_line, *version, *extract_group, *size_group, *match_group, *seed;
};

const FakeVersion kVersions[] = {
    {"COLMAP 3.8 -- Structure-from-Motion and Multi-View Stereo", "3.8", "SiftExtraction", "SiftExtraction", "SiftMatching",
     "random_seed"},
    {"COLMAP 3.9.1 -- Structure-from-Motion and Multi-View Stereo", "3.9.1", "SiftExtraction", "SiftExtraction", "SiftMatching",
     "random_seed"},
    {"COLMAP 3.12.0.dev0 -- Structure-from-Motion", "3.12.0.dev0", "SiftExtraction", "SiftExtraction", "SiftMatching",
     "random_seed"},
    {"COLMAP 3.13.0 -- Structure-from-Motion", "3.13.0", "FeatureExtraction", "SiftExtraction", "FeatureMatching",
     "default_random_seed"},
    {"COLMAP 4.0.0 -- Structure-from-Motion", "4.0.0", "FeatureExtraction", "FeatureExtraction", "FeatureMatching",
     "default_random_seed"},
    {"COLMAP 4.1.1 (Commit abc)", "4.1.1", "FeatureExtraction", "FeatureExtraction", "FeatureMatching", "default_random_seed"},
};

fs::path write_program(const fs::path& folder, const std::string& text) {
  const fs::path path = folder / "colmap with space";
  write_file(path, "#!/bin/sh\n" + text);
  fs::permissions(path, fs::perms::owner_all);
  return path;
}

fs::path fake_colmap(const fs::path& folder, const FakeVersion& v) {
  const std::string e = v.extract_group, m = v.match_group;
  return write_program(folder, std::string("if [ \"$1\" = -h ]; then echo '") + v.first_line +
                                   "'; exit 0; fi\n"
                                   "if [ \"$1\" = mapper ]; then echo 'ERROR: Command `mapper` not recognized.'; exit 1; fi\n"
                                   "if [ \"$2\" = -h ]; then\n"
                                   "echo '  -h [ --help ]'\n"
                                   "echo '  --database_path arg'\necho '  --image_path arg'\n"
                                   "echo '  --" +
                                   v.seed +
                                   " arg (=0)'\n"
                                   "echo '  --" +
                                   e +
                                   ".use_gpu arg (=1)'\n"
                                   "echo '  --" +
                                   e +
                                   ".num_threads arg (=-1)'\n"
                                   "echo '  --" +
                                   v.size_group +
                                   ".max_image_size arg (=3200)'\n"
                                   "echo '  --" +
                                   m +
                                   ".use_gpu arg (=1)'\n"
                                   "exit 0; fi\n"
                                   "for a in \"$@\"; do printf '%s\\n' \"<$a>\"; done\n"
                                   "exit 3\n");
}

TEST(ColmapDriver, FindsTheOptionNamesOfSixVersions) {
  for (const FakeVersion& v : kVersions) {
    const TemporaryFolder folder;
    Colmap colmap(fake_colmap(folder.path(), v));
    EXPECT_EQ(colmap.version(), v.version);
    EXPECT_EQ(colmap.option("feature_extractor", "extract_gpu"), std::string("--") + v.extract_group + ".use_gpu");
    EXPECT_EQ(colmap.option("feature_extractor", "extract_max_size"), std::string("--") + v.size_group + ".max_image_size");
    EXPECT_EQ(colmap.option("feature_extractor", "match_gpu"), std::string("--") + v.match_group + ".use_gpu");
    EXPECT_EQ(colmap.option("feature_extractor", "seed"), std::string("--") + v.seed);
    EXPECT_EQ(colmap.option("feature_extractor", "output"), std::nullopt);
  }
}

TEST(ColmapDriver, PassesArgumentsWithoutAShellAndReportsTheExitCode) {
  const TemporaryFolder folder;
  Colmap colmap(fake_colmap(folder.path(), kVersions[0]));
  std::vector<std::string> lines;
  const ProcessResult result =
      colmap.run({.command = "feature_extractor",
                  .settings = {{"database", "a b;$(touch x)'\".db"}, {"images", "Fotos/Küche"}, {"output", "left out", false}},
                  .working_folder = folder.path(),
                  .log = folder.path() / "log.txt",
                  .on_line = [&](std::string_view line) { lines.emplace_back(line); }});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(lines, (std::vector<std::string>{"<feature_extractor>", "<--database_path>", "<a b;$(touch x)'\".db>",
                                             "<--image_path>", "<Fotos/Küche>"}));
  EXPECT_FALSE(fs::exists(folder.path() / "x"));
  EXPECT_NE(read_file(folder.path() / "log.txt").find("<Fotos/Küche>"), std::string::npos);
}

TEST(ColmapDriver, GivesPathsFromTheWorkingFolderBecauseColmapChangesBackslashes) {
  const TemporaryFolder folder;
  Colmap colmap(fake_colmap(folder.path(), kVersions[0]));
  const fs::path there = folder.path() / "back\\slash";
  make_folders(there);
  std::vector<std::string> lines;
  colmap.run({.command = "feature_extractor",
              .settings = {{"database", (there / "a.db").string()}, {"images", (there / "pictures").string()}},
              .working_folder = there,
              .log = there / "log.txt",
              .on_line = [&](std::string_view line) { lines.emplace_back(line); }});
  EXPECT_EQ(lines,
            (std::vector<std::string>{"<feature_extractor>", "<--database_path>", "<a.db>", "<--image_path>", "<pictures>"}));
}

TEST(ColmapDriver, NamesAMissingOptionAndTheVersion) {
  const TemporaryFolder folder;
  Colmap colmap(fake_colmap(folder.path(), kVersions[5]));
  const Error e = error_of([&] { colmap.run({.command = "feature_extractor", .settings = {{"match_threads", "1"}}}); });
  EXPECT_EQ(e.kind(), ErrorKind::Dependency);
  EXPECT_EQ(e.detail().code, "COLMAP_OPTION_MISSING");
  EXPECT_NE(e.message().find("4.1.1"), std::string::npos);
  EXPECT_NE(e.message().find("--SiftMatching.num_threads or --FeatureMatching.num_threads"), std::string::npos);
}

TEST(ColmapDriver, ReportsACommandThatTheProgramLacks) {
  const TemporaryFolder folder;
  Colmap colmap(fake_colmap(folder.path(), kVersions[0]));
  EXPECT_EQ(error_of([&] { colmap.run({.command = "mapper", .settings = {}}); }).detail().code, "COLMAP_COMMAND_MISSING");
}

TEST(ColmapDriver, RefusesAProgramThatIsNotColmap) {
  const TemporaryFolder folder;
  const fs::path program = write_program(folder.path(), "echo 'Usage: something else'\n");
  const Error e = error_of([&] { Colmap colmap(program); });
  EXPECT_EQ(exit_code(e.kind()), 7);
  EXPECT_EQ(e.detail().code, "COLMAP_UNUSABLE");
}

TEST(ColmapDriver, SaysHowToInstallAMissingColmap) {
  const char* before = std::getenv("VITRINE_COLMAP");
  const std::string kept = before == nullptr ? "" : before;
  setenv("VITRINE_COLMAP", "/nowhere/colmap", 1);
  const Error e = error_of([] { Colmap colmap; });
  EXPECT_EQ(colmap_fingerprint(), "none");
  before == nullptr ? unsetenv("VITRINE_COLMAP") : setenv("VITRINE_COLMAP", kept.c_str(), 1);
  EXPECT_EQ(exit_code(e.kind()), 7);
  EXPECT_NE(e.detail().hint.find("apt-get install"), std::string::npos);
  EXPECT_NE(e.message().find("/nowhere/colmap"), std::string::npos);
}

}  // namespace
}  // namespace vitrine
