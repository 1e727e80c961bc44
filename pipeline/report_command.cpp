// vitrine report PROJECT: writes the HTML report of a run.
#include <iostream>

#include "core/foundation/base/error.h"
#include "core/foundation/config/cli.h"
#include "pipeline/commands.h"
#include "pipeline/pages.h"
#include "pipeline/project.h"

namespace vitrine {

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
