// vitrine view PROJECT: one HTML page that shows the scene in any browser, without a server. The work is done by the program
// vitrine-view, which stands beside the stages but not in their graph.
#include <iostream>

#include "core/config/cli.h"
#include "pipeline/browser.h"
#include "pipeline/commands.h"
#include "pipeline/project.h"
#include "pipeline/view_page.h"

namespace vitrine {

int view_command(const Words& words) {
  std::string output;
  Words sets;
  bool edited = false, open = false, force = false, quiet = false, no_progress = false, help = false;
  int threads = 0;
  CommandLine cli(
      "vitrine view", "[PROJECT] [options]",
      "One HTML page that shows the scene from any side, relit by any HDRI, glass included: any browser opens it, without "
      "a server or a network. PROJECT is the output folder of `vitrine run`, which does this at its end; default: the "
      "current folder.");
  cli.value("output", 'o', "FILE", output, "The page; default: PROJECT/view.html.");
  cli.flag("open", 0, open, "Open it in the browser.");
  cli.flag("edited", 0, edited, "The scene with its edits (vitrine edit), into PROJECT/edited/view.html.");
  cli.values("set", 0, "OPTION=VALUE", sets, "An option of vitrine-view.");
  cli.flag("force", 0, force, "Make the page even if it is in the store.");
  cli.value("threads", 'j', "N", threads, 0, "Threads; 0 = all. The page does not depend on it.");
  cli.flag("no-progress", 0, no_progress, "No progress bar, no progress lines.");
  cli.flag("quiet", 'q', quiet, "Warnings and errors only.");
  cli.flag("help", 'h', help, "Print this text.");
  const Words rest = cli.parse(words, 1);
  if (help) {
    std::cout << cli.help();
    return 0;
  }
  const fs::path project = project_of(rest.empty() ? "." : rest[0]);
  const ProjectLock lock(project);
  Words how;
  if (no_progress) how.emplace_back("--no-progress");
  if (quiet) how.emplace_back("--quiet");
  fs::path edits;
  if (edited) {
    const EditedScene scene = edited_scene(project, {}, how);
    if (scene.exit_code != 0) return scene.exit_code;
    edits = scene.folder;
  }
  Words call = tool_call("view", project, view_inputs(edits));
  for (const std::string& set : sets) call.insert(call.end(), {"--set", set});
  if (threads > 0) call.insert(call.end(), {"--threads", std::to_string(threads)});
  if (force) how.emplace_back("--force");
  const ToolResult page = run_tool("view", project, call, how);
  if (page.exit_code != 0) return page.exit_code;
  const fs::path made = view_page_path(page.entry);
  fs::path file = output.empty() ? view_page_path(edited ? edited_folder(project) : project) : fs::absolute(output);
  if (output.empty() && !edited)
    keep_view_page(project, page);
  else
    write_file(file, read_file(made));
  if (!quiet) fmt::print("{}\n", file.string());
  if (open) open_in_browser(file);
  return 0;
}

}  // namespace vitrine
