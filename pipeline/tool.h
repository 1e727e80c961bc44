// Programs that run on a project's artifacts outside `vitrine run`: render, relight, edit, and the export stage with other
// options. They read the current artifacts, store their own in the project's store, and report their own errors.
#pragma once

#include <filesystem>
#include <optional>
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

// The HTML pages of an output folder: report.html by the program vitrine-report (pipeline/report_page), at the end of every
// `vitrine run`, including failed ones, and by `vitrine report`; view.html by the program vitrine-view (stages/view), at the end
// of every `vitrine run` that trained a scene, and by `vitrine view`.

fs::path html_report_path(const fs::path& project);
// Returns nothing on success, otherwise the reason. The signal that stopped the run does not stop it.
std::optional<std::string> write_html_report(const fs::path& project, bool only_if_changed);

fs::path view_page_path(const fs::path& project);
// The relit picture made with the page (stages/view/view.cpp).
fs::path relit_sample_path(const fs::path& project);
// Inputs of the page.
ToolInputs view_inputs(const fs::path& edited = {});
// Links the page into the project folder and records it as current.
void keep_view_page(const fs::path& project, const ToolResult& page);

enum class ViewPage : unsigned char { Written, NoScene, Failed };
struct ViewPageOutcome {
  ViewPage what = ViewPage::NoScene;
  std::string why = {};  // reason of Failed
};
// For the end of a run: prints nothing, throws nothing, and ignores the signal that stopped the run. The project must be locked.
ViewPageOutcome write_view_page(const fs::path& project);

// Checks given poses and masks for `vitrine inspect`: executes a run up to the camera poses on reduced copies of the photos.

struct RehearsalDesc {
  std::filesystem::path photos;
  std::string poses = {};  // as --poses; without poses there is no rehearsal, since estimating them takes minutes
  std::string masks = {};  // as --masks, or empty
  int threads = 0;
};

// A warning of the run, or the error that ended it.
struct RunMessage {
  bool error = false;
  std::string code = {};  // code of the run: "POSES_DISAGREE"
  std::string what = {}, why = {}, hint = {};
};

std::vector<RunMessage> rehearsed(const RehearsalDesc& desc);

}  // namespace vitrine
