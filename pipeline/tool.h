// Programs that run on a project's artifacts outside `vitrine run`: render, relight, edit, and the export stage with other
// options. They read the current artifacts, store their own in the project's store, and report their own errors.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/artifact/manifest.h"
#include "core/foundation/base/file.h"
#include "core/foundation/config/cli.h"
#include "pipeline/commands.h"

namespace vitrine {

// Common options of commands that start one program on a project: render, relight, view, mark, export, edit.
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

// Arguments for the program: threads and output.
Words work_words(const ToolOptions& o);
Words quietness(const ToolOptions& o);

struct ToolInputs {
  std::vector<std::string> stages;         // required artifacts
  std::vector<std::string> optional = {};  // optional artifacts
  std::string missing;                     // error message if one of `stages` was not computed: "there is no trained scene yet"
  fs::path edited = {};  // folder that replaces optimize, refine, mesh and decompose; may be empty (edited_scene)
};
// First words of a call of the tool: program, store and inputs. Throws Error if one is missing.
Words tool_call(const std::string& tool, const fs::path& project, const ToolInputs& inputs);

struct ToolResult {
  int exit_code = 0;  // the program has reported the error
  std::string key = {};
  Manifest manifest = {};
  fs::path entry = {};  // its artifact
};
ToolResult run_tool(const std::string& tool, const fs::path& project, const Words& call, const Words& how = {});

// Applies the edits of PROJECT/edited/edits.yaml, or of `edits`, to the current artifacts and links the result into
// PROJECT/edited; a cache lookup if nothing changed. The folder in the store is a valid ToolInputs::edited; empty, with the exit
// code, if the program failed. The project must be locked.
struct EditedScene {
  int exit_code = 0;
  fs::path folder = {};
};
EditedScene edited_scene(const fs::path& project, const fs::path& edits, const Words& how);
inline fs::path edited_folder(const fs::path& project) { return project / "edited"; }

// Runs a program with its own output; returns its exit code.
int run_and_tell(const Words& words);
fs::path tool_program(const std::string& tool);

// Opens an HTML page in the user's browser (--open). Throws Error{Dependency} if no program opens a browser.
void open_in_browser(const fs::path& page);

}  // namespace vitrine
