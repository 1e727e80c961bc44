// vitrine ct SCAN.yaml -o DIR: a volume from X-ray projections, with the program vitrine-tomography. Its files are linked into
// DIR/ct; there is no scene, so DIR is no folder for other commands.
#include <iostream>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/config/cli.h"
#include "pipeline/project.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

constexpr const char* kCtTool = "tomography";
constexpr const char* kCtUsage = "vitrine ct SCAN.yaml -o DIR";

// The folder must be free, or of an earlier `vitrine ct`, whose files are replaced, or which was interrupted.
void check_ct_output(const fs::path& out) {
  std::error_code ec;
  if (!fs::exists(out, ec) || current_key(out, kCtTool) || (fs::is_directory(out, ec) && fs::is_empty(out, ec))) return;
  if (!is_project(out) && fs::is_directory(store_of(out) / kCtTool, ec)) return;
  throw Error(ErrorKind::Usage, "the output folder contains other files",
              {.where = out.string(),
               .why = is_project(out) ? "it is the output folder of a run" : "it was not made by vitrine ct",
               .hint = "choose another one with -o",
               .code = "USAGE"});
}

void keep_volume(const fs::path& project, const ToolResult& result) {
  const ArtifactStore store(store_of(project));
  const auto last = current_key(project, kCtTool);
  const auto before = last ? store.find(kCtTool, *last) : std::nullopt;
  publish(result.entry, result.manifest, project, before ? &*before : nullptr);
  set_current_key(project, kCtTool, result.key);
}

}  // namespace

int ct_command(const Words& words) {
  ToolOptions how;
  std::string output;
  CommandLine cli(
      "vitrine ct", "SCAN.yaml -o DIR [options]",
      "A volume from X-ray projections (parallel or cone beam): slices as EXR, a NRRD file, the surface as PLY, and "
      "a page that shows them. SCAN.yaml describes geometry, angles and pictures; stages/tomography/README.md shows the format.");
  cli.value("output", 'o', "DIR", output, "Output folder: missing, empty, or of an earlier vitrine ct.");
  add_set_option(cli, how, kCtTool);
  add_usual_options(cli, how, "Files do");
  const Words rest = cli.parse(words, 1);
  if (how.help) {
    std::cout << cli.help();
    return 0;
  }
  const fs::path file = fs::absolute(only_argument(rest, "which scan?", kCtUsage)).lexically_normal();
  if (output.empty()) throw Error(ErrorKind::Usage, "where does the volume go?", {.hint = kCtUsage, .code = "USAGE"});
  std::error_code ec;
  if (!fs::is_regular_file(file, ec))
    throw Error(ErrorKind::Input, "there is no such description of a scan",
                {.where = file.string(), .hint = kCtUsage, .code = "MISSING_INPUT"});
  const fs::path project = fs::absolute(output).lexically_normal();
  check_ct_output(project);
  const bool kept = fs::exists(project, ec);
  int exit = 0;
  {
    make_folders(store_of(project));
    const ProjectLock lock(project);
    Words call{tool_program(kCtTool).string(), "--store", store_of(project).string(), "--input", "scan=" + file.string()};
    const Words work = work_words(how);
    call.insert(call.end(), work.begin(), work.end());
    const ToolResult result = run_tool(kCtTool, project, call, quietness(how));
    exit = result.exit_code;
    if (exit == 0) keep_volume(project, result);
  }
  const bool goes_on = exit == exit_code(ErrorKind::Interrupted) || exit == exit_code(ErrorKind::Preempted);
  if (exit != 0 && !kept && !goes_on) fs::remove_all(project, ec);
  if (exit == 0 && !how.quiet) fmt::print("{}\n", (project / "ct").string());
  return exit;
}

}  // namespace vitrine
