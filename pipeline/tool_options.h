// Common options of commands that start one program on a project: render, relight, view, mark, export, edit.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/config/cli.h"
#include "pipeline/commands.h"

namespace vitrine {

struct ToolOptions {
  std::vector<std::string> sets;
  int threads = 0;
  bool no_progress = false, quiet = false, help = false;
};
// --set OPTION=VALUE, for the program vitrine-<tool>.
void add_set_option(CommandLine& cli, ToolOptions& o, std::string_view tool);
// --threads, --no-progress, --quiet and --help, at the end of a list of options. `results`, for the help text: "Files do" not
// depend on the number of threads.
void add_usual_options(CommandLine& cli, ToolOptions& o, std::string_view results);

// The one argument of a command. Throws Error{Usage} with `question` where there is none.
const std::string& only_argument(const Words& rest, const char* question, const char* usage);

// What the program is given of them: how it works, and what it prints.
Words work_words(const ToolOptions& o);
Words quietness(const ToolOptions& o);

}  // namespace vitrine
