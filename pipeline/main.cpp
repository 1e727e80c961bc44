// vitrine: command dispatch and the single catch block.
#include <cstdio>
#include <iostream>
#include <new>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/terminal.h"
#include "core/foundation/config/text.h"
#include "pipeline/commands.h"

namespace {

using namespace vitrine;

struct Command {
  const char *name, *doc;
  int (*run)(const Words&);
};

constexpr Command kCommands[] = {
    {"inspect", "what a folder of photos promises, and what a run would take", inspect_command},
    {"mark", "one page to mark glass and metal in: writes marks.yaml for a run", mark_command},
    {"run", "photos in, scene out; computes what is not up to date", run_command},
    {"render", "pictures of the trained scene, from its cameras or along a path", render_command},
    {"relight", "pictures of the scene under another light: an HDRI, lamps", relight_command},
    {"view", "one page that shows the scene in a browser: OUT/view.html", view_command},
    {"edit", "changes to a finished scene: materials, deletion; replayable", edit_command},
    {"compose", "several finished scenes, or objects of them, in one", compose_command},
    {"ct", "a volume from X-ray projections: slices, NRRD, surface", ct_command},
    {"export", "the scene in other programs' formats; --list shows what each holds", export_command},
    {"report", "one page about the run and its result: OUT/report.html", report_command},
    {"status", "which stages of an output folder are up to date", status_command},
    {"explain", "why a stage would be computed again", explain_command},
    {"config", "all options, their values and where they come from", config_command},
    {"cache", "size of the store; remove what is not current", cache_command},
    {"farm", "many captures: a table of tasks, engines that run them, their state", farm_command},
    {"doctor", "what this machine has, and what is missing", doctor_command},
};

std::string help() {
  std::string text =
      "usage: vitrine COMMAND ...\nRaw photos in, a relightable scene out, glass and mirrors included.\n\ncommands:\n";
  for (const Command& c : kCommands) text += fmt::format("  {:<10}{}\n", c.name, c.doc);
  return text + "\nvitrine COMMAND --help shows more.\nFirst run: vitrine run PHOTOS -o DIR --preset preview\n";
}

int dispatch(const Words& words) {
  if (words.empty() || words[0] == "--help" || words[0] == "-h" || words[0] == "help") {
    std::cout << help();
    return words.empty() ? exit_code(ErrorKind::Usage) : 0;
  }
  if (words[0] == "--version") {
    std::cout << "vitrine " << VITRINE_VERSION << "\n";
    return 0;
  }
  require_current_folder();
  Words names;
  for (const Command& c : kCommands) {
    if (words[0] == c.name) return c.run(Words(words.begin() + 1, words.end()));
    names.push_back(c.name);
  }
  const std::string near = nearest_word(words[0], names);
  throw Error(ErrorKind::Usage,
              fmt::format("there is no command '{}'{}", words[0],
                          near.empty() ? std::string() : fmt::format("; did you mean '{}'?", near)),
              {.hint = "vitrine --help", .code = "USAGE"});
}

int complain(const Error& e) {
  std::fflush(stdout);
  clear_status_line();
  fmt::print(stderr, "{}\n", e.with_prefix());
  return exit_code(e.kind());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    install_interrupt_handlers();
    return dispatch(Words(argv + 1, argv + argc));
  } catch (const Error& e) {
    return complain(e);
  } catch (const std::bad_alloc&) {
    return complain(
        Error(ErrorKind::Resource, "out of memory",
              {.why = "the system gave no more memory", .hint = "end other programs, or fewer photos", .code = "OUT_OF_MEMORY"}));
  } catch (const std::filesystem::filesystem_error& e) {
    return complain(error_of_file_system(e));
  } catch (const std::exception& e) {
    return complain(Error(ErrorKind::Internal, fmt::format("internal error: {}", e.what()),
                          {.hint = "this is a bug in vitrine: please report it", .code = "INTERNAL"}));
  }
}
