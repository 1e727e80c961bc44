// vitrine report PROJECT: writes the HTML report of a run.
#include <iostream>

#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/cli.h"
#include "pipeline/commands.h"
#include "pipeline/graph.h"
#include "pipeline/html_report.h"
#include "pipeline/project.h"

namespace vitrine {

namespace {

// The path as typed in the current folder.
fs::path typed(const fs::path& project) {
  const fs::path here = project.lexically_relative(fs::current_path());
  return here.empty() || *here.begin() == ".." ? project : here;
}

}  // namespace

fs::path html_report_path(const fs::path& project) { return project / "report.html"; }

std::optional<std::string> write_html_report(const fs::path& project, bool only_if_changed) {
  const fs::path program = own_folder() / "vitrine-report";
  std::error_code ec;
  if (!fs::exists(program, ec)) return "the program vitrine-report is missing";
  std::vector<std::string> words = {program.string(), project.string(), "--typed", typed(project).string()};
  if (only_if_changed) words.push_back("--if-changed");
  try {
    const ProcessResult result =
        run_process({.arguments = words, .on_line = [](std::string_view) {}, .forward_interrupts = false});
    if (result.ok()) return std::nullopt;
    const std::string first = result.tail.substr(0, result.tail.find('\n'));
    return first.empty() ? fmt::format("vitrine-report ended with {}", result.signal != 0 ? "a signal" : "an error") : first;
  } catch (const Error& e) {  // the program cannot be started
    return e.message();
  }
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
