#include "stages/stage_cli.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/config/schema.h"
#include "core/foundation/config/text.h"

namespace vitrine {

using json = nlohmann::ordered_json;

namespace {

CommandLine stage_command_line(const StageInfo& info, StageArguments& a) {
  CommandLine cli("vitrine-" + info.name, "--input NAME=PATH... --output DIR [options]", info.summary);
  if (info.device.choose != nullptr) {
    cli.section("pictures");
    cli.value("device", 0, "cpu|cuda|auto", a.device, "Where they are computed; auto: a GPU where one is usable.");
  }
  cli.section("files");
  cli.values("input", 'i', "NAME=PATH", a.inputs, "An input; names are listed below.");
  cli.value("output", 'o', "DIR", a.output, "Folder in which the finished files appear.");
  cli.value("store", 0, "DIR", a.store, "Where artifacts are kept and found again; default: .cache in the output folder.");
  cli.section("configuration");
  cli.values("config", 'c', "FILE", a.configs, "YAML file with options; later files win.");
  cli.values("set", 0, "OPTION=VALUE", a.sets, "One option; wins over files.");
  cli.values("set-from", 0, "ORIGIN|OPTION=VALUE", a.sets_from,
             "One option, with the place it was given in for messages and the manifest.");
  cli.flag("force", 0, a.force, "Compute even if the result is in the store.");
  cli.section("machine");
  cli.value("threads", 'j', "N", a.threads, 0, "Threads; 0 = all. The result does not depend on it.");
  cli.value("max-memory", 0, "SIZE", a.max_memory, "Memory to stay below: 4GiB, 512M, 80%.");
  cli.section("reports");
  cli.value("events", 0, "FILE", a.events, "Append records, one JSON object per line.");
  cli.value("log-file", 0, "FILE", a.log_file, "Append everything that is logged.");
  cli.value("log-format", 0, "text|json", a.log_format, "json: records on stdout instead of lines on stderr.");
  cli.flag("no-progress", 0, a.no_progress, "No progress bar, no progress lines.");
  cli.flag("quiet", 'q', a.quiet, "Warnings and errors only.");
  cli.flag("verbose", 'v', a.verbose, "More detail.");
  cli.section("about");
  cli.flag("describe", 0, a.describe, "Print inputs, options and report figures as JSON.");
  cli.value("cost", 0, "FILE", a.cost, "Print what runs would take, as JSON; the file names photos and options.");
  cli.flag("print-key", 0, a.print_key, "Print the cache key of this run and its terms as JSON; compute nothing.");
  cli.flag("version", 0, a.version, "Print the version.");
  cli.flag("help", 'h', a.help, "Print this text.");
  return cli;
}

}  // namespace

StageArguments parse_stage_arguments(const StageInfo& info, const std::vector<std::string>& words) {
  StageArguments a;
  const std::vector<std::string> rest = stage_command_line(info, a).parse(words);
  if (!rest.empty())
    throw Error(
        ErrorKind::Usage, fmt::format("unexpected argument \"{}\"", rest[0]),
        {.hint = fmt::format("inputs are given as --input NAME=PATH; see vitrine-{} --help", info.name), .code = "USAGE"});
  if (a.log_format != "text" && a.log_format != "json")
    throw Error(ErrorKind::Usage, fmt::format("--log-format must be text or json, got \"{}\"", a.log_format),
                {.hint = "--log-format json", .code = "USAGE"});
  if (std::ranges::find(kDeviceWords, a.device) == kDeviceWords.end())
    throw Error(ErrorKind::Usage, fmt::format("--device must be one of {}, got \"{}\"", fmt::join(kDeviceWords, ", "), a.device),
                {.hint = "--device auto", .code = "USAGE"});
  return a;
}

std::string stage_help(const StageInfo& info, const OptionTable& options) {
  StageArguments unused;
  std::string tail = "inputs:\n";
  for (const StageInput& input : info.inputs) {
    tail += fmt::format("  {}{}{}\n", input.name, input.artifact ? " (artifact)" : "", input.optional ? " (optional)" : "");
    for (const std::string& line : wrapped(input.doc, 74)) tail += fmt::format("      {}\n", line);
  }
  if (info.inputs.empty()) tail += "  none\n";
  tail += "\nstage options, for --set and YAML files:\n";
  tail += options.options.empty() ? std::string("  none\n") : help_text(options);
  return stage_command_line(info, unused).help(tail);
}

std::string stage_description(const StageInfo& info, const OptionTable& options) {
  nlohmann::ordered_json out = {{"format", 1}, {"name", info.name}, {"version", info.version}, {"summary", info.summary}};
  out["inputs"] = nlohmann::ordered_json::array();
  for (const StageInput& i : info.inputs)
    out["inputs"].push_back(
        {{"name", i.name}, {"artifact", i.artifact}, {"optional", i.optional}, {"doc", i.doc}, {"skips", i.skips}});
  out.update(nlohmann::ordered_json::parse(options_to_json(options)));
  out["doing"] = info.doing;
  if (info.device.choose != nullptr) out["devices"] = info.device.has_kernels() ? json::array({"cpu", "cuda"}) : json::array({"cpu"});
  out["has_cost"] = info.cost != nullptr;
  out["report"] = nlohmann::ordered_json::parse(stage_report_text(info.report));
  return out.dump(1);
}

std::string stage_cost_answer(const StageInfo& info, const std::string& file) {
  if (info.cost == nullptr)
    throw Error(ErrorKind::Usage, fmt::format("vitrine-{} has no estimate of its costs", info.name),
                {.hint = "stages/README.md shows how a stage declares one", .code = "USAGE"});
  std::vector<StageCost> costs;
  for (const CostTerms& terms : cost_terms_from_json(read_file(file))) costs.push_back(info.cost(terms));
  return to_json(costs);
}

void apply_stage_config(const StageArguments& arguments, const StageInfo& info, OptionTable& options) {
  ConfigErrors errors;
  for (const std::string& path : arguments.configs) {
    const YamlFile file = read_yaml(path);
    // The stage's section of the file; null if the whole file holds its options.
    const YamlNode* section = options.find(info.name) == nullptr ? file.root.find(info.name) : nullptr;
    apply_yaml(file, section ? *section : file.root, options, {.shown = section ? info.name : std::string()}, errors);
  }
  for (const std::string& word : arguments.sets_from) {
    const size_t bar = word.find('|');
    if (bar == std::string::npos)
      errors.add("--set-from", fmt::format("expected ORIGIN|path=value, got \"{}\"", word));
    else
      apply_set(std::string_view(word).substr(bar + 1), options, word.substr(0, bar), errors);
  }
  for (const std::string& word : arguments.sets) apply_set(word, options, "--set", errors);
  errors.throw_if_any(fmt::format("vitrine-{} --help lists every option", info.name));
}

}  // namespace vitrine
