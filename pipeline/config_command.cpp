// vitrine config show | schema | reference: available options and their current values.
#include <iostream>

#include "core/foundation/base/error.h"
#include "core/foundation/config/cli.h"
#include "core/foundation/config/schema.h"
#include "pipeline/commands.h"
#include "pipeline/project.h"

namespace vitrine {

namespace {

// Options of one stage, without the stage prefix.
std::string stage_reference(const StageNode& node) {
  OwnedOptions options;
  options.add_json(node.description, "");
  return fmt::format("# Options of stage '{}': {}\n# Written by `vitrine config reference`; values are the defaults.\n{}:\n{}",
                     node.name, node.summary, node.name,
                     options.table.options.empty() ? "  {}\n" : yaml_text(options.table, {.documentation = true, .indent = 2}));
}

std::string whole_reference(const Graph& graph) {
  const Settings settings(graph);
  return "# Every option with its default. Written by `vitrine config reference`.\n" +
         yaml_text(settings.options.table, {.documentation = true});
}

}  // namespace

int config_command(const Words& words) {
  bool help = false, origin = false;
  std::string write, preset;
  std::vector<std::string> configs, sets;
  CommandLine cli("vitrine config", "show|schema|reference [PROJECT|STAGE]",
                  "show: every value as a run would use it. schema: all options as JSON. reference: all options, or those of a "
                  "stage, as YAML with "
                  "their documentation.");
  cli.flag("origin", 0, origin, "show: the place each value comes from, behind it.");
  cli.value("preset", 0, "NAME", preset, "show: with this preset.");
  cli.values("config", 'c', "FILE", configs, "show: with this file.");
  cli.values("set", 0, "STAGE.OPTION=VALUE", sets, "show: with this value.");
  cli.value("write", 0, "DIR", write, "reference: write one file per stage into this folder.");
  cli.flag("help", 'h', help, "Print this text.");
  const Words rest = cli.parse(words, 2);
  if (help) {
    std::cout << cli.help();
    return 0;
  }
  if (rest.empty())
    throw Error(ErrorKind::Usage, "show, schema or reference?",
                {.hint = "vitrine config show PROJECT --origin", .code = "USAGE"});
  const Graph graph = load_graph(stage_folder());
  if (rest[0] == "reference") {
    if (!write.empty())
      for (const StageNode& node : graph.nodes) write_file(fs::path(write) / (node.name + ".yaml"), stage_reference(node));
    else
      std::cout << (rest.size() == 2 ? stage_reference(graph.at(rest[1])) : whole_reference(graph));
    return 0;
  }
  Settings settings(graph);
  if (rest[0] == "schema") {
    std::cout << options_to_json(settings.options.table) << "\n";
    return 0;
  }
  if (rest[0] != "show")
    throw Error(ErrorKind::Usage, fmt::format("show, schema or reference? got \"{}\"", rest[0]),
                {.hint = "vitrine config --help", .code = "USAGE"});
  const fs::path project = fs::absolute(rest.size() == 2 ? rest[1] : ".").lexically_normal();
  if (rest.size() == 2 && !is_project(project))
    throw Error(ErrorKind::Input, "this is no output folder of vitrine",
                {.where = project.string(), .hint = "vitrine run PHOTOS -o DIR makes one", .code = "NO_PROJECT"});
  SettingsDesc desc{.project = project, .configs = configs, .sets = sets};
  if (!preset.empty()) desc.flags.push_back({"preset", preset, "--preset"});
  settings.load(desc);
  std::cout << yaml_text(settings.options.table, {.origins = origin});
  return 0;
}

}  // namespace vitrine
