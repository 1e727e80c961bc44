// vitrine view PROJECT: one HTML page that shows the scene in any browser, without a server; with the program vitrine-view.
// vitrine report PROJECT: writes the HTML report of a run.
#include <iostream>

#include "core/foundation/base/error.h"
#include "core/foundation/config/cli.h"
#include "pipeline/commands.h"
#include "pipeline/project.h"
#include "pipeline/tool.h"

namespace vitrine {

int view_command(const Words& words) {
  std::string output;
  ToolOptions how;
  bool edited = false, open = false, force = false;
  CommandLine cli(
      "vitrine view", "[PROJECT] [options]",
      "One HTML page that shows the scene from any side, relit by any HDRI, glass included: any browser opens it, without "
      "a server or a network. PROJECT is the output folder of `vitrine run`, which does this at its end; default: the "
      "current folder.");
  cli.value("output", 'o', "FILE", output, "The page; default: PROJECT/view.html.");
  cli.flag("open", 0, open, "Open it in the browser.");
  cli.flag("edited", 0, edited, "The scene with its edits (vitrine edit), into PROJECT/edited/view.html.");
  add_set_option(cli, how, "view");
  cli.flag("force", 0, force, "Make the page even if it is in the store.");
  add_usual_options(cli, how, "The page does");
  const Words rest = cli.parse(words, 1);
  if (how.help) {
    std::cout << cli.help();
    return 0;
  }
  const fs::path project = project_of(rest.empty() ? "." : rest[0]);
  const ProjectLock lock(project);
  Words quietly = quietness(how);
  fs::path edits;
  if (edited) {
    const EditedScene scene = edited_scene(project, {}, quietly);
    if (scene.exit_code != 0) return scene.exit_code;
    edits = scene.folder;
  }
  Words call = tool_call("view", project, view_inputs(edits));
  const Words work = work_words(how);
  call.insert(call.end(), work.begin(), work.end());
  if (force) quietly.emplace_back("--force");
  const ToolResult page = run_tool("view", project, call, quietly);
  if (page.exit_code != 0) return page.exit_code;
  const fs::path made = view_page_path(page.entry);
  fs::path file = output.empty() ? view_page_path(edited ? edited_folder(project) : project) : fs::absolute(output);
  if (output.empty() && !edited)
    keep_view_page(project, page);
  else
    write_file(file, read_file(made));
  if (!how.quiet) fmt::print("{}\n", file.string());
  if (open) open_in_browser(file);
  return 0;
}

int report_command(const Words& words) {
  bool help = false;
  CommandLine cli(
      "vitrine report", "[PROJECT]",
      "Writes PROJECT/report.html: what the run gave, how good it is, what to try next; one file, to be opened in any browser. "
      "PROJECT is the output folder of `vitrine run`, which does this at its end; default: the current folder.");
  cli.flag("help", 'h', help, "Print this text.");
  const Words rest = cli.parse(words, 1);
  if (help) {
    std::cout << cli.help();
    return 0;
  }
  const fs::path project = project_of(rest.empty() ? "." : rest[0]);
  if (const auto why = write_html_report(project, false))
    throw Error(ErrorKind::Resource, "the report could not be written",
                {.where = html_report_path(project).string(),
                 .why = *why,
                 .hint = "the run itself is not touched by that",
                 .code = "REPORT_FAILED"});
  fmt::print("{}\n", html_report_path(project).string());
  return 0;
}

}  // namespace vitrine
