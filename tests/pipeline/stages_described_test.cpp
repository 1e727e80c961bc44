// Rules that hold for every real stage, read from what its executable says of itself.
#include <algorithm>
#include <cctype>
#include <chrono>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/schema.h"
#include "pipeline/settings.h"
#include "tests/pipeline/built_stages.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

std::string output_of(const std::vector<std::string>& arguments) {
  std::string text;
  const ProcessResult r =
      run_process({.arguments = arguments, .on_line = [&](std::string_view line) { text += std::string(line) + "\n"; }});
  EXPECT_TRUE(r.ok()) << join_command(arguments) << "\n" << text;
  return text;
}

// What the build wrote down saves starting every program; it must be what they say.
TEST(Stages, AreDescribedByFilesBesideThemAsTheyDescribeThemselves) {
  for (const StageNode& n : graph().nodes) {
    ASSERT_TRUE(fs::exists(n.executable.string() + ".json")) << n.name;
    EXPECT_EQ(read_file(n.executable.string() + ".json"), output_of({n.executable.string(), "--describe"})) << n.name;
  }
}

TEST(Stages, AreAskedWhereTheFileIsOlderThanTheProgramOrDamaged) {
  const TemporaryFolder folder;
  const fs::path program = folder.path() / "vitrine-one", file = folder.path() / "vitrine-one.json";
  const auto described = [](const char* summary) {
    return fmt::format(R"({{"format": 1, "name": "one", "version": 1, "summary": "{}", "inputs": [], "options": []}})", summary);
  };
  write_file(folder.path() / "vitrine.stages", "one\n");
  write_file(program, "#!/bin/sh\necho '" + described("asked") + "'\n");
  fs::permissions(program, fs::perms::owner_all);
  const auto summary = [&] { return load_graph(folder.path()).nodes.at(0).summary; };
  EXPECT_EQ(summary(), "asked");
  write_file(file, described("written"));
  fs::last_write_time(file, fs::last_write_time(program) + std::chrono::seconds(1));
  EXPECT_EQ(summary(), "written");
  fs::last_write_time(file, fs::last_write_time(program) - std::chrono::seconds(1));
  EXPECT_EQ(summary(), "asked");
  for (const std::string& damaged : {described("written").substr(0, 20), std::string("[1]")}) {
    write_file(file, damaged);
    fs::last_write_time(file, fs::last_write_time(program) + std::chrono::seconds(1));
    EXPECT_EQ(summary(), "asked") << damaged;
  }
}

TEST(Stages, StandInAnOrderThatCanRun) {
  std::set<std::string> done;
  for (const StageNode& n : graph().nodes) {
    for (const NodeInput& i : n.inputs) EXPECT_TRUE(!i.artifact || done.contains(i.name)) << n.name << " reads " << i.name;
    done.insert(n.name);
  }
}

TEST(Stages, DocumentEveryOptionAndInput) {
  for (const StageNode& n : graph().nodes) {
    EXPECT_FALSE(n.summary.empty()) << n.name;
    EXPECT_GE(n.version, 1);
    for (const NodeInput& i : n.inputs) EXPECT_FALSE(i.doc.empty()) << n.name << "." << i.name;
    OwnedOptions options;
    options.add_json(n.description, n.name);
    for (const Option& o : options.table.options) {
      EXPECT_GE(o.doc.size(), 12u) << o.path << " needs a sentence";
      EXPECT_TRUE(o.doc.empty() || o.doc.back() == '.' || o.doc.back() == ')') << o.path << ": a sentence ends with a full stop";
      for (char c : o.path) EXPECT_TRUE(std::islower(c) || std::isdigit(c) || c == '_' || c == '.') << o.path;
      const bool number = o.type() == "int" || o.type() == "float";
      EXPECT_TRUE(!number || (o.low.has_value() && o.high.has_value())) << o.path << " needs a range";
    }
    for (const OptionGroup& g : options.table.groups) EXPECT_FALSE(g.doc.empty()) << g.path;
  }
}

TEST(Stages, DefaultsObeyTheirOwnRules) {
  for (const StageNode& n : graph().nodes) {
    OwnedOptions options;
    options.add_json(n.description, n.name);
    for (Option& o : options.table.options) {
      const auto broken = o.try_assign(o.default_text, "default");
      EXPECT_FALSE(broken) << o.path << " " << broken.value_or("");
    }
  }
}

TEST(Stages, HelpFitsEightyColumnsAndListsEveryOption) {
  for (const StageNode& n : graph().nodes) {
    const std::string help = output_of({n.executable.string(), "--help"});
    EXPECT_TRUE(help.starts_with(fmt::format("usage: vitrine-{} ", n.name)));
    for (size_t at = 0, end; (end = help.find('\n', at)) != std::string::npos; at = end + 1)
      EXPECT_LE(end - at, 80u) << n.name << ": " << help.substr(at, end - at);
    OwnedOptions options;
    options.add_json(n.description, "");
    for (const Option& o : options.table.options)
      EXPECT_NE(help.find("  " + o.path + ":"), std::string::npos) << n.name << "." << o.path;
  }
}

TEST(Stages, ReferenceFilesAreUpToDate) {
  const TemporaryFolder written;
  output_of({std::string(VITRINE_BIN_DIR) + "/vitrine", "config", "reference", "--write", written.path().string()});
  for (const StageNode& n : graph().nodes) {
    const fs::path file = fs::path(VITRINE_SOURCE_DIR) / "configs/reference" / (n.name + ".yaml");
    ASSERT_TRUE(fs::exists(file)) << file << " is missing: build the target `reference`";
    EXPECT_EQ(read_file(file), read_file(written.path() / (n.name + ".yaml")))
        << file << " is out of date: build the target `reference` and commit it";
  }
  const std::string first = graph().nodes.front().name;
  EXPECT_EQ(output_of({std::string(VITRINE_BIN_DIR) + "/vitrine", "config", "reference", first}),
            read_file(written.path() / (first + ".yaml")));
}

// A commit that raises the ceiling gives the reason: a value that no preset, document or user sets is a constant.
TEST(Stages, HaveAtMost146Options) {
  size_t count = 0;
  for (const StageNode& n : graph().nodes) {
    OwnedOptions options;
    options.add_json(n.description, "");
    count += options.table.options.size();
  }
  EXPECT_LE(count, 146u);
}

TEST(Presets, AreReadWithoutComplaint) {
  const std::vector<std::string> presets = preset_names();
  for (const char* wanted : {"preview", "standard", "high"})
    EXPECT_NE(std::find(presets.begin(), presets.end(), wanted), presets.end()) << wanted;
  for (const std::string& preset : presets) {
    Settings settings(graph());
    EXPECT_NO_THROW(settings.load({.flags = {{"preset", preset, "--preset"}}})) << preset;
    EXPECT_EQ(settings.text("preset"), preset);
  }
}

}  // namespace
}  // namespace vitrine
