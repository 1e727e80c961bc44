// What every program and command says to --help, word for word, and the template that all of it fits.
#include "core/foundation/base/process.h"
#include "tests/golden/golden.h"

namespace vitrine {
namespace {

using golden::lines_of;
using Words = std::vector<std::string>;

constexpr const char *kFirstShared = "\nfiles:\n", *kAfterShared = "\ninputs:\n", *kOptions = "\nstage options, ";

std::string help_of(Words words) {
  words[0] = std::string(VITRINE_BIN_DIR) + "/" + words[0];
  words.emplace_back("--help");
  std::string text;
  const ProcessResult r =
      run_process({.arguments = words, .on_line = [&](std::string_view line) { text += std::string(line) + "\n"; }});
  EXPECT_TRUE(r.ok()) << join_command(words) << "\n" << text;
  return text;
}

// "usage: PROGRAM ...", a sentence or two, headlines that end with a colon, two or more spaces before what stands below them.
void expect_template(const std::string& program, const std::string& help) {
  const std::vector<std::string> lines = lines_of(help);
  ASSERT_GE(lines.size(), 3u) << program;
  EXPECT_TRUE(lines[0].starts_with("usage: " + program)) << lines[0];
  EXPECT_FALSE(lines[1].empty()) << program << " does not say what it is for";
  EXPECT_NE(help.find("--help"), std::string::npos) << program;
  for (size_t i = 0; i < lines.size(); ++i) {
    EXPECT_LE(lines[i].size(), 80u) << program << ": " << lines[i];
    EXPECT_FALSE(lines[i].ends_with(' ')) << program << ": \"" << lines[i] << "\"";
    EXPECT_EQ(lines[i].find('\t'), std::string::npos) << program << ": " << lines[i];
    EXPECT_FALSE(lines[i].starts_with("  ") && lines[i - 1].empty()) << program << ": no headline above " << lines[i];
  }
}

TEST(GoldenHelp, OfEveryProgramAndCommand) {
  std::string all;
  const auto add = [&](const std::string& program, const std::string& help) {
    expect_template(program, help);
    all += fmt::format("$ {} --help\n{}\n", program, help);
  };
  const std::string overview = help_of({"vitrine"});
  add("vitrine", overview);
  bool commands = false;
  for (const std::string& line : lines_of(overview)) {
    if (commands && line.empty()) break;
    if (commands) {
      const std::string name = line.substr(2, line.find(' ', 2) - 2);
      add("vitrine " + name, help_of({"vitrine", name}));
    }
    commands |= line == "commands:";
  }
  add("vitrine-report", help_of({"vitrine-report"}));
  // All stages and tools have one part in common, which is kept once. Their options are golden in configs/reference, as YAML.
  std::string shared;
  Words stages = lines_of(read_file(fs::path(VITRINE_BIN_DIR) / "vitrine.stages"));
  std::istringstream tools(VITRINE_TOOLS);
  for (std::string tool; tools >> tool;) stages.push_back(tool);
  for (const std::string& stage : stages) {
    const std::string program = "vitrine-" + stage, help = help_of({program});
    const size_t first = help.find(kFirstShared), after = help.find(kAfterShared), options = help.find(kOptions);
    ASSERT_LT(first, after) << help;
    ASSERT_LT(after, options) << help;
    if (shared.empty()) {
      shared = help.substr(first, after - first);
      all += fmt::format("$ vitrine-STAGE --help: what all stages have in common\n{}\n", shared.substr(1));
    }
    EXPECT_EQ(help.substr(first, after - first), shared) << program;
    expect_template(program, help);
    all += fmt::format("$ {} --help\n{}{}\n", program, help.substr(0, first), help.substr(after, options - after));
  }
  golden::expect_golden("help.txt", all);
}

}  // namespace
}  // namespace vitrine
