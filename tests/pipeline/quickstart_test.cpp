// pipeline/quickstart.sh: which commands it calls. It runs beside a setup.sh that installs and builds nothing, and calls a
// program that writes down its words.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"

namespace vitrine {
namespace {

class Quickstart : public testing::Test {
 protected:
  Quickstart() {
    for (const char* sub : {"pipeline", "build/bin", "photos"}) make_folders(folder.path() / sub);
    fs::copy_file(fs::path(VITRINE_SOURCE_DIR) / "pipeline/quickstart.sh", folder.path() / "pipeline/quickstart.sh");
    write_file(folder.path() / "pipeline/setup.sh", "VITRINE_ROOT=\"" + folder.path().string() +
                                                        "\"\nVITRINE_PACKAGES=()\n"
                                                        "install_packages() { :; }\nbuild() { :; }\nsay() { echo \"$*\"; }\n");
    write_file(program(), "#!/bin/sh\necho \"$*\" >> \"" + (folder.path() / "calls").string() + "\"\n");
    fs::permissions(program(), fs::perms::owner_all);
  }
  fs::path program() const { return folder.path() / "build/bin/vitrine"; }
  fs::path out() const { return folder.path() / "out"; }
  // The first words of every call, one a line.
  std::string calls(const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"bash", (folder.path() / "pipeline/quickstart.sh").string(),
                                          (folder.path() / "photos").string(), "-o", out().string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    fs::remove(folder.path() / "calls");
    printed.clear();
    const ProcessResult r = run_process({.arguments = arguments, .on_line = [&](std::string_view line) {
                                           printed += line;
                                           printed += '\n';
                                         }});
    EXPECT_TRUE(r.ok()) << r.tail;
    std::istringstream lines(read_file(folder.path() / "calls"));
    std::string commands;
    for (std::string line; std::getline(lines, line);) commands += line.substr(0, line.find(' ')) + "\n";
    return commands;
  }

  TemporaryFolder folder;
  std::string printed;
};

TEST_F(Quickstart, FindsThePhotosWhereverTheyStand) {
  const auto words = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"bash", (folder.path() / "pipeline/quickstart.sh").string()});
    fs::remove(folder.path() / "calls");
    const ProcessResult r = run_process({.arguments = arguments, .on_line = [](std::string_view) {}});
    return r.ok() ? read_file(folder.path() / "calls") : fmt::format("code {}", r.exit_code);
  };
  const std::string photos = (folder.path() / "photos").string();
  const std::string expected =
      fmt::format("run {} -o {} --preset preview --set mesh.voxel=1 --no-progress\n", photos, out().string());
  EXPECT_EQ(words({photos, "-o", out().string(), "--set", "mesh.voxel=1", "--no-progress"}), expected);
  EXPECT_EQ(words({"-o", out().string(), "--set", "mesh.voxel=1", "--no-progress", photos}), expected);
  EXPECT_EQ(words({"-j4", photos, "-o", out().string()}),
            fmt::format("run {} -o {} --preset preview -j4\n", photos, out().string()));
  EXPECT_EQ(words({photos, photos}), "code 2");
  EXPECT_EQ(words({"-o", out().string(), "--preset"}), "code 2");
  EXPECT_EQ(words({"/nowhere"}), "code 3");
}

TEST_F(Quickstart, RelightsWhatHasMaterialsOnly) {
  EXPECT_EQ(calls({"--to", "mesh"}), "run\n");
  EXPECT_EQ(printed.find("relit/"), std::string::npos) << printed;
  make_folders(out() / "decompose");
  write_file(out() / "decompose/materials.ply", "ply\n");
  make_folders(out() / "relit");
  EXPECT_EQ(calls({}), "run\nrelight\nrelight\nreport\n");
  EXPECT_NE(printed.find(out().string() + "/relit/"), std::string::npos) << printed;
  EXPECT_EQ(calls({"--dry-run"}), "run\n");
}

}  // namespace
}  // namespace vitrine
