// The package `vitrine`: scripts in this folder check it on a finished project of two balls (tests/stages/compose/projects.h),
// and the example of its README runs.
#include <gtest/gtest.h>

#include "core/foundation/base/process.h"
#include "pipeline/commands.h"
#include "tests/stages/compose/projects.h"

namespace vitrine {
namespace {

const fs::path kSources = VITRINE_SOURCE_DIR;

class PythonPackage : public testing::Test {
 protected:
  fs::path project() const { return projects_.at("room"); }
  // Runs a script in the folder of the projects.
  void run(const fs::path& script, const std::vector<std::string>& arguments = {}) const {
    std::vector<std::string> words{VITRINE_PYTHON_PROGRAM, script.string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const ProcessResult result =
        run_process({.arguments = words,
                     .environment = {{"PYTHONPATH", VITRINE_PYTHON_PACKAGES}, {"PYTHONDONTWRITEBYTECODE", "1"}},
                     .working_folder = projects_.at("")});
    EXPECT_TRUE(result.ok()) << result.tail;
  }
  void check(const char* script) const { run(kSources / "tests/pipeline/python" / script, {project().string()}); }
  test::Projects projects_;
};

TEST_F(PythonPackage, PicturesAreThoseOfTheCommands) {
  const Words quiet{"--quiet", "--no-progress", "--size", "48x32"};
  Words render{project().string(), "--views", "all"},
      relight{project().string(), "--turntable", "2", "--spp", "4", "--exposure", "0"};
  render.insert(render.end(), quiet.begin(), quiet.end());
  relight.insert(relight.end(), quiet.begin(), quiet.end());
  ASSERT_EQ(render_command(render), 0);
  ASSERT_EQ(relight_command(relight), 0);
  check("pictures.py");
}

TEST_F(PythonPackage, GradientsAreFiniteDifferences) { check("gradients.py"); }

TEST_F(PythonPackage, ScenesAreArrays) { check("arrays.py"); }

TEST_F(PythonPackage, TheExampleOfItsReadmeRuns) {
  const std::string page = read_file(kSources / "pipeline/python/README.md"), open = "```python\n";
  const size_t begin = page.find(open), end = page.find("```\n", begin + open.size());
  ASSERT_NE(end, std::string::npos);
  fs::create_directory_symlink(project(), projects_.at("out"));
  const fs::path script = projects_.at("example.py");
  write_file(script, page.substr(begin + open.size(), end - begin - open.size()));
  run(script);
}

}  // namespace
}  // namespace vitrine
