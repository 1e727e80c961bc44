#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/config/schema.h"
#include "core/foundation/config/text.h"
#include "core/foundation/config/yaml.h"
#include "tests/core/foundation/config/example.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using example::Config;

// The whole complaint about a file, or "" when it is fine.
std::string complaint(const std::string& yaml, Config& config, const ApplyDesc& desc = {}) {
  OptionTable table = options_of(config);
  try {
    const YamlFile file = parse_yaml(yaml, "kettle.yaml");
    ConfigErrors errors;
    apply_yaml(file, file.root, table, desc, errors);
    errors.throw_if_any("");
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Usage);
    return e.what();
  }
  return {};
}
std::string complaint(const std::string& yaml) {
  Config config;
  return complaint(yaml, config);
}

TEST(Yaml, ReadsEveryKindOfOption) {
  Config c;
  EXPECT_EQ(complaint("voxel: 0.002\niterations: 5\nbackend: reference\nschedule: [0.5, 1]\nformats: glb\nfusion:\n  carve: yes\n"
                      "note: \"a: b # c\"\n",
                      c),
            "");
  EXPECT_FLOAT_EQ(c.voxel, 0.002f);
  EXPECT_EQ(c.iterations, 5);
  EXPECT_EQ(c.backend, example::Renderer::Reference);
  EXPECT_EQ(c.schedule, (std::vector<double>{0.5, 1}));
  EXPECT_EQ(c.formats, std::vector<std::string>{"glb"});
  EXPECT_TRUE(c.fusion.carve);
  EXPECT_EQ(c.note, "a: b # c");
}

TEST(Yaml, SuggestsTheNearestOptionOnTypo) {
  EXPECT_EQ(complaint("iterations: 7\nvoxle: 0.002\n"),
            "kettle.yaml:2:1: error: unknown key 'voxle'; did you mean 'voxel'?\n"
            "    2 | voxle: 0.002\n"
            "      | ^~~~~\n"
            "1 error");
}

TEST(Yaml, NamesValueAndRuleWhenOutOfRange) {
  EXPECT_EQ(complaint("fusion:\n  weight_cap: 5000\n"),
            "kettle.yaml:2:15: error: 'fusion.weight_cap' must be a number between 1 and 1000, got \"5000\"\n"
            "    2 |   weight_cap: 5000\n"
            "      |               ^~~~\n"
            "1 error");
}

TEST(Yaml, CollectsAllErrorsOfAFile) {
  const std::string all =
      complaint("iterations: 12k\nbackend: cpuu\nfusion: 3\nschedule: [0.5, 2]\nvoxel: 0.01\nvoxel: 0.02\nxyzzy: 1\n");
  EXPECT_NE(all.find("kettle.yaml:1:13: error: 'iterations' must be an integer between 1 and 100000, got \"12k\""),
            std::string::npos)
      << all;
  EXPECT_NE(all.find("'backend' must be one of cpu, reference, got \"cpuu\"; did you mean \"cpu\"?"), std::string::npos) << all;
  EXPECT_NE(all.find("kettle.yaml:3:9: error: 'fusion' must be a map of options"), std::string::npos) << all;
  EXPECT_NE(all.find("'schedule' must be a list of numbers between 0 and 1, got \"2\" in it"), std::string::npos) << all;
  EXPECT_NE(all.find("kettle.yaml:6:1: error: 'voxel' is given twice (first on line 5)"), std::string::npos) << all;
  EXPECT_NE(all.find("unknown key 'xyzzy'\n"), std::string::npos) << all;
  EXPECT_NE(all.find("6 errors"), std::string::npos) << all;
}

TEST(YamlReader, RefusesUnknownAndRepeatedKeysAtTheirPlace) {
  YamlReader reader(parse_yaml("size: [4, 3]\nmarks: 1\nmark: 2\n  \nsize: [3, 4]\n", "marks.yaml"));
  reader.only_keys(reader.root(), {"size", "marks"});
  const std::string all = error_of([&] { reader.finish("hint"); }).what();
  EXPECT_NE(all.find("marks.yaml:3:1: error: unknown key 'mark'; did you mean 'marks'?"), std::string::npos) << all;
  EXPECT_NE(all.find("marks.yaml:5:1: error: 'size' is given twice (first on line 1)"), std::string::npos) << all;
  EXPECT_NE(all.find("2 errors"), std::string::npos) << all;
}

TEST(Yaml, WhatTheEndOfTheFileLacksIsShownOnTheLastLine) {
  for (const char* end : {"", "\n", "\n \n"}) {
    const std::string text = complaint(std::string("backend: cpu\nschedule: [0.5, 1") + end);
    EXPECT_TRUE(text.starts_with("kettle.yaml:2:18: error: not valid YAML: ")) << text;
    EXPECT_NE(text.find("    2 | schedule: [0.5, 1\n      |                  ^\n"), std::string::npos) << text;
  }
}

TEST(Yaml, WhatIsWrongInTheMiddleIsShownThere) {
  const std::string indented = complaint("backend: cpu\nfusion:\n  weight_cap: 5\n schedule: [0, 1]\nvoxel: 1\n");
  EXPECT_TRUE(indented.starts_with("kettle.yaml:4:2: error: not valid YAML: ")) << indented;
  const std::string comma = complaint("backend: cpu\nfusion: {weight_cap: 5 voxel: 3}\nvoxel: 1\n");
  EXPECT_TRUE(comma.starts_with("kettle.yaml:2:")) << comma;
}

TEST(Yaml, SyntaxErrorsPointAtTheirPlace) {
  const std::string text = complaint("voxel: [0.1\niterations: 3\n");
  EXPECT_NE(text.find("kettle.yaml:2:"), std::string::npos) << text;
  EXPECT_NE(text.find("not valid YAML"), std::string::npos) << text;
  EXPECT_NE(complaint("a: &x 1\n").find("anchors (&name) are not supported"), std::string::npos);
  EXPECT_NE(complaint("a: 1\n---\nb: 2\n").find("a second document"), std::string::npos);
  EXPECT_NE(complaint("- 1\n").find("must be a map"), std::string::npos);
  EXPECT_NE(complaint("voxel:\n").find("'voxel' must be a number between 0.0001 and 0.1, got nothing"), std::string::npos);
  EXPECT_NE(complaint("voxel: .nan\n").find("got \".nan\""), std::string::npos);
  EXPECT_EQ(complaint(""), "");
  EXPECT_EQ(complaint("# only a comment\n"), "");
}

TEST(Yaml, RemembersWhereAValueCameFrom) {
  Config c;
  OptionTable table = options_of(c);
  const YamlFile file = parse_yaml("fusion:\n    carve: true\n", "a.yaml");
  ConfigErrors errors;
  apply_yaml(file, file.root, table, {.origin = "preset high"}, errors);
  EXPECT_TRUE(errors.empty());
  EXPECT_EQ(table.find("fusion.carve")->origin, "preset high (a.yaml:2:5)");
  EXPECT_EQ(table.find("voxel")->origin, "default");
}

TEST(Set, ReadsPathAndValue) {
  Config c;
  OptionTable table = options_of(c);
  ConfigErrors errors;
  apply_set("fusion.weight-cap=8", table, "--set", errors);
  apply_set("formats=[glb, ply]", table, "--set", errors);
  apply_set("note=x=y", table, "--set", errors);
  EXPECT_TRUE(errors.empty());
  EXPECT_EQ(c.fusion.weight_cap, 8);
  EXPECT_EQ(c.formats, (std::vector<std::string>{"glb", "ply"}));
  EXPECT_EQ(c.note, "x=y");
  EXPECT_EQ(table.find("note")->origin, "--set");
}

TEST(Set, ComplainsAboutWhatIsWrong) {
  Config c;
  OptionTable table = options_of(c);
  ConfigErrors errors;
  apply_set("voxel", table, "--set", errors);
  apply_set("weight_cap=3", table, "--set", errors);
  apply_set("fusion=3", table, "--set", errors);
  apply_set("voxel=1", table, "--set", errors);
  try {
    errors.throw_if_any("");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.message(),
              "--set: error: expected path=value, got \"voxel\"\n"
              "--set: error: unknown key 'weight_cap'; did you mean 'fusion.weight_cap'?\n"
              "--set: error: 'fusion' is a group of options: name one of them, as in fusion.NAME=VALUE\n"
              "--set: error: 'voxel' must be a number between 0.0001 and 0.1, got \"1\"\n"
              "4 errors");
  }
}

TEST(Option, AssignThrowsWithOptionValueAndRule) {
  Config c;
  OptionTable table = options_of(c);
  try {
    table.find("iterations")->assign("0", "--set");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.message(), "'iterations' must be an integer between 1 and 100000, got \"0\"");
    EXPECT_EQ(e.detail().where, "--set");
  }
  EXPECT_EQ(c.iterations, 12000);
}

TEST(CanonicalText, HoldsWhatAffectsTheResultAndNothingElse) {
  Config c;
  OptionTable table = options_of(c);
  const std::string before = table.canonical_text();
  EXPECT_EQ(before.find("threads"), std::string::npos);
  c.threads = 7;
  EXPECT_EQ(table.canonical_text(), before);
  c.voxel = 0.1f;
  EXPECT_NE(table.canonical_text().find("voxel = 0.1\n"), std::string::npos) << table.canonical_text();
  c.note = "\nvoxel = 9";
  EXPECT_NE(table.canonical_text().find("note = \"\\nvoxel = 9\"\n"), std::string::npos);
}

TEST(YamlText, ReadsBackToTheSameValues) {
  Config c;
  c.voxel = 0.0333333333f;
  c.note = "it's \"5\": # x\ttab\nline\x01";
  c.formats = {};
  c.backend = example::Renderer::Reference;
  c.fusion.carve = true;
  OptionTable table = options_of(c);
  for (bool documented : {false, true}) {
    const std::string text = yaml_text(table, {.documentation = documented});
    Config again;
    EXPECT_EQ(complaint(text, again), "") << text;
    EXPECT_EQ(options_of(again).canonical_text(), table.canonical_text()) << text;
  }
}

TEST(Schema, TableSurvivesJson) {
  Config c;
  OptionTable table = options_of(c);
  OwnedOptions copy;
  copy.add_json(options_to_json(table), "mesh");
  ASSERT_EQ(copy.table.options.size(), table.options.size());
  for (size_t i = 0; i < table.options.size(); ++i) {
    const Option &a = table.options[i], &b = copy.table.options[i];
    EXPECT_EQ(b.path, "mesh." + a.path);
    EXPECT_EQ(b.text(), a.text());
    EXPECT_EQ(b.rule(), a.rule());
    EXPECT_EQ(b.affects_result, a.affects_result);
  }
  EXPECT_TRUE(copy.table.find("mesh.voxel")->try_assign("7", "x").has_value());
}

TEST(HelpText, FitsEightyColumnsAndNamesEveryOption) {
  Config c;
  const OptionTable table = options_of(c);
  const std::string help = help_text(table);
  for (const Option& o : table.options) EXPECT_NE(help.find(o.path), std::string::npos);
  for (size_t at = 0, end; (end = help.find('\n', at)) != std::string::npos; at = end + 1) EXPECT_LE(end - at, 80u);
}

TEST(NearestWord, FindsTyposAndRefusesTheFarAway) {
  const std::vector<std::string> words = {"voxel", "iterations", "fusion.weight_cap"};
  EXPECT_EQ(nearest_word("voxle", words), "voxel");
  EXPECT_EQ(nearest_word("Iteration", words), "iterations");
  EXPECT_EQ(nearest_word("weight_cap", words), "fusion.weight_cap");
  EXPECT_EQ(nearest_word("xy", words), "");
  EXPECT_EQ(nearest_word("albedo", words), "");
  EXPECT_EQ(edit_distance("abcd", "acbd"), 1u);
}

}  // namespace
}  // namespace vitrine
