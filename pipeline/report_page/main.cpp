// vitrine-report: writes report.html of an output folder. Started by `vitrine report` and at the end of `vitrine run`. A separate
// program, so that `vitrine` needs no image library and a damaged folder cannot crash the end of a run.
#include <cstdio>
#include <exception>

#include "core/foundation/base/error.h"
#include "core/foundation/config/cli.h"
#include "pipeline/report_page/page.h"

namespace {

using namespace vitrine;

int report(const std::vector<std::string>& words) {
  std::string typed;
  bool if_changed = false, help = false;
  CommandLine cli("vitrine-report", "FOLDER [options]",
                  "Writes FOLDER/report.html: what a run gave, how good it is, what to try next.");
  cli.value("typed", 0, "PATH", typed, "The folder as commands in the report shall name it.");
  cli.flag("if-changed", 0, if_changed, "Do nothing when the report is up to date.");
  cli.flag("help", 'h', help, "Print this text.");
  const std::vector<std::string> rest = cli.parse(words);
  if (help) {
    fmt::print("{}", cli.help());
    return 0;
  }
  if (rest.size() != 1) throw Error(ErrorKind::Usage, "which folder?", {.hint = "vitrine-report FOLDER", .code = "USAGE"});
  const PageDesc desc{.project = fs::absolute(rest[0]).lexically_normal(), .typed = typed};
  const fs::path file = desc.project / "report.html";
  if (if_changed && state_of_page(file) == page_state(desc)) return 0;
  write_file(file, report_page(desc));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return report({argv + 1, argv + argc});
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.with_prefix());
    return exit_code(e.kind());
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return exit_code(ErrorKind::Internal);
  }
}
