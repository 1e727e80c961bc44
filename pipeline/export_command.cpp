// vitrine export PROJECT: writes formats for other programs in addition to those of `vitrine run`, with the export stage. This
// command places the files and replaces existing ones only with --overwrite.
#include <algorithm>
#include <iostream>

#include <nlohmann/json.hpp>

#include "core/foundation/base/error.h"
#include "core/foundation/config/chart.h"
#include "core/foundation/config/cli.h"
#include "core/foundation/config/text.h"
#include "pipeline/graph.h"
#include "pipeline/project.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

struct ExportArguments : ToolOptions {
  std::string output, formats, axes, scale, scale_bar, scale_points;
  bool list = false, overwrite = false, edited = false;
};

CommandLine export_command_line(ExportArguments& a) {
  CommandLine cli("vitrine export", "[PROJECT] [options]",
                  "Files for other programs. PROJECT is the output folder of `vitrine run`; default: the current folder.");
  cli.flag("list", 0, a.list, "What each format holds and what is lost on the way; writes nothing.");
  cli.value("formats", 'f', "A,B,...", a.formats, "Which formats; default: all.");
  cli.value("axes", 0, "AXES", a.axes, "Frame of the files: rhzu, rhyu, lhzu or lhyu (right- or left-handed, z or y up).");
  cli.value("scale", 0, "LENGTH", a.scale, "Length of one scene unit, as 0.24m, 24cm, or a bare number.");
  cli.value("scale-bar", 0, "MARKS", a.scale_bar,
            "A scale bar in the picture: its two ends in two or more photos and its length, "
            "\"PHOTO:X1,Y1,X2,Y2 PHOTO:X1,Y1,X2,Y2 = 5cm\", in pixels of PROJECT/images.");
  cli.value("scale-points", 0, "POINTS", a.scale_points,
            "Two points of the scene and the length between them, \"X,Y,Z X,Y,Z 24cm\": `vitrine view` writes it (Measure).");
  cli.flag("edited", 0, a.edited, "The scene with its edits (vitrine edit), into PROJECT/edited/export.");
  cli.value("output", 'o', "DIR", a.output, "Where the files go; default: PROJECT/export.");
  cli.flag("overwrite", 0, a.overwrite, "Replace files that are there with other contents.");
  add_set_option(cli, a, "export");
  add_usual_options(cli, a, "Files do");
  return cli;
}

// The stage checks `--set formats=...` too; for --formats the hint refers to the list of formats.
void check_formats(const std::string& given) {
  if (given.empty()) return;
  const auto about = nlohmann::json::parse(load_graph(stage_folder()).at("export").description);
  for (const nlohmann::json& option : about.at("options")) {
    if (option.at("path") != "formats") continue;
    const auto known = option.at("choices").get<std::vector<std::string>>();
    for (const std::string& format : split_list(given)) {
      if (std::ranges::find(known, format) != known.end()) continue;
      const std::string near = nearest_word(format, known);
      throw Error(ErrorKind::Usage,
                  fmt::format("there is no format '{}'{}", format, near.empty() ? "" : fmt::format("; did you mean '{}'?", near)),
                  {.why = fmt::format("the formats are: {}", fmt::join(known, " ")),
                   .hint = "`vitrine export --list` shows what each holds",
                   .code = "USAGE"});
    }
  }
}

// Parses a length in metres.
double metres(const std::string& text) {
  const auto length = parse_length(text);
  if (!length)
    throw Error(ErrorKind::Usage, fmt::format("--scale must look like 0.24m, 24cm or 1.5, got \"{}\"", text),
                {.hint = "a length of the whole scene's unit: 0.24m makes one unit 24 cm", .code = "USAGE"});
  return length->metres;
}

// One measure of the unit at most, and readable.
void check_unit(const ExportArguments& a) {
  std::vector<std::string_view> given;
  for (const auto& [name, text] :
       {std::pair("--scale", &a.scale), {"--scale-bar", &a.scale_bar}, {"--scale-points", &a.scale_points}})
    if (!text->empty()) given.push_back(name);
  if (given.size() > 1)
    throw Error(ErrorKind::Usage, fmt::format("{} and {} both give the unit", given[0], given[1]),
                {.hint = "leave one of them out", .code = "USAGE"});
  if (!a.scale_bar.empty()) parse_scale_bar(a.scale_bar);
  if (!a.scale_points.empty()) parse_scale_points(a.scale_points);
}

}  // namespace

int export_command(const Words& words) {
  ExportArguments a;
  const CommandLine cli = export_command_line(a);
  const Words rest = cli.parse(words, 1);
  if (a.help) {
    std::cout << cli.help();
    return 0;
  }
  if (a.list) return run_and_tell({tool_program("export").string(), "--list"});
  check_formats(a.formats);
  check_unit(a);
  const fs::path project = project_of(rest.empty() ? "." : rest[0]);
  const ProjectLock lock(project);
  const fs::path target = result_folder(project, (a.edited ? edited_folder(project) : project) / kExportStage, a.output);
  ToolInputs inputs{.stages = {"sfm", "optimize", "mesh"},
                    .optional = {"refine", "decompose", "objects"},
                    .missing = "there is no scene to export yet"};
  const Words how = quietness(a);
  if (a.edited) {
    const EditedScene edited = edited_scene(project, {}, how);
    if (edited.exit_code != 0) return edited.exit_code;
    inputs.edited = edited.folder;
  }
  Words run = tool_call("export", project, inputs);
  if (!a.formats.empty()) run.insert(run.end(), {"--set", "formats=[" + a.formats + "]"});
  if (!a.axes.empty()) run.insert(run.end(), {"--set", "axes=" + a.axes});
  if (!a.scale.empty()) run.insert(run.end(), {"--set", fmt::format("scale={}", metres(a.scale))});
  if (!a.scale_bar.empty()) run.insert(run.end(), {"--set", "scale_bar=" + a.scale_bar});
  if (!a.scale_points.empty()) run.insert(run.end(), {"--set", "scale_points=" + a.scale_points});
  const Words work = work_words(a);
  run.insert(run.end(), work.begin(), work.end());

  const ToolResult result = run_tool("export", project, run, how);
  if (result.exit_code != 0) return result.exit_code;

  put_export(result.entry, result.manifest, {.project = project, .target = target, .overwrite = a.overwrite});
  if (!a.quiet) fmt::print("{}\n", target.string());
  return 0;
}

}  // namespace vitrine
