// vitrine mark PHOTOS|PROJECT: one HTML page to annotate glass and metal, which saves marks.yaml for a run. For an output folder
// it also shows the propagated masks in every photo. Uses the program vitrine-mark.
#include <iostream>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/cli.h"
#include "core/foundation/config/text.h"
#include "pipeline/commands.h"
#include "pipeline/graph.h"
#include "pipeline/project.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

constexpr const char* kPage = "mark.html";

// By name only: the file may not exist.
bool called_marks(const fs::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".yaml" || extension == ".yml";
}

struct MarkSubject {
  fs::path photos;
  fs::path marks = {};                   // existing marks to continue with
  std::optional<fs::path> project = {};  // output folder of an earlier run
  std::string command = {};              // `vitrine run` command with the marks
};

// Photos of a project for the page: where frames of films are among them, the upright copies that ingest has made.
fs::path shown_photos(const fs::path& project, const fs::path& given) {
  const auto key = current_key(project, "ingest");
  if (!key || !gives_film_frames(given)) return given;
  return store_of(project) / "ingest" / *key / "ingest" / "ldr";
}

MarkSubject subject_of(const std::string& word, const std::string& marks) {
  const fs::path what = fs::absolute(word).lexically_normal();
  MarkSubject s{.photos = what};
  if (!marks.empty()) s.marks = fs::absolute(marks);
  if (!is_project(what)) {
    s.command = join_command({"vitrine", "run", word, "-o", default_project(what).filename().string(), "--masks", "marks.yaml"});
    return s;
  }
  s.project = what;
  s.command = join_command({"vitrine", "run", word, "--masks", "marks.yaml"});
  Settings settings(load_graph(stage_folder()));
  settings.load({.project = what});
  s.photos = shown_photos(what, settings.text("input.photos"));
  std::error_code ec;
  const fs::path before = settings.text("input.masks");
  if (marks.empty() && called_marks(before)) {
    if (fs::exists(before, ec))
      s.marks = before;
    else
      log_warning("warning: the marks of this run are not there any more ({}): the page begins without marks", before.string());
  }
  return s;
}

// Inputs from the finished stages of the run.
Words results_of(const fs::path& project) {
  const auto current = current_keys(project);
  Words words;
  for (const std::string stage : {"sfm", "masks"}) {
    const auto key = current.find(stage);
    if (key == current.end()) {
      log_warning(
          "warning: the stage '{}' of this run has not been computed: the page does not show what it knows (try: vitrine run {})",
          stage, join_command({project.string()}));
      return words;
    }
    words.insert(words.end(), {"--input", fmt::format("{}={}", stage, (store_of(project) / stage / key->second).string())});
  }
  return words;
}

}  // namespace

int mark_command(const Words& words) {
  std::string output, marks;
  ToolOptions how;
  bool open = false;
  CommandLine cli("vitrine mark", "PHOTOS|PROJECT [options]",
                  "One HTML page that shows the photos and lets you draw what is glass, metal, the object, or not to be used; it "
                  "saves marks.yaml for `vitrine run --masks`. Any browser opens it, without a server or a network. Of PROJECT, "
                  "the output folder of `vitrine run`, it begins with the marks of that run and shows what they became in every "
                  "photo.");
  cli.value("output", 'o', "FILE", output, "The page; default: mark.html in the current folder, or PROJECT/mark.html.");
  cli.value("masks", 0, "FILE", marks, "A file of marks to go on with; default: that of PROJECT.");
  cli.flag("open", 0, open, "Open it in the browser.");
  add_set_option(cli, how, "mark");
  add_usual_options(cli, how, "The page does");
  const Words rest = cli.parse(words);
  if (how.help) {
    std::cout << cli.help();
    return 0;
  }
  const std::string& given = only_argument(rest, "which photos?", "vitrine mark PHOTOS");
  if (!marks.empty() && !called_marks(marks))
    throw Error(ErrorKind::Usage, "this is no file of marks",
                {.where = marks,
                 .why = "marks are a file called .yaml",
                 .hint = "vitrine mark PHOTOS --masks marks.yaml",
                 .code = "USAGE"});
  if (std::error_code ec; !marks.empty() && !fs::is_regular_file(marks, ec))
    throw Error(ErrorKind::Input, "there is no such file of marks",
                {.where = marks, .hint = "leave out --masks to begin without marks", .code = "MISSING_INPUT"});
  const MarkSubject subject = subject_of(given, marks);
  const TemporaryFolder folder("vitrine-mark");
  const fs::path made = folder.path() / "page";
  Words call = {tool_program("mark").string(), "--input", "photos=" + subject.photos.string(), "--output", made.string(), "--set",
                "command=" + subject.command};
  if (!subject.marks.empty()) call.insert(call.end(), {"--input", "marks=" + subject.marks.string()});
  if (subject.project) {
    const Words results = results_of(*subject.project);
    call.insert(call.end(), results.begin(), results.end());
  }
  for (const Words& more : {work_words(how), quietness(how)}) call.insert(call.end(), more.begin(), more.end());
  if (const int exit = run_and_tell(call); exit != 0) return exit;
  const fs::path file = output.empty() ? subject.project.value_or(fs::current_path()) / kPage : fs::absolute(output);
  write_file(file, read_file(made / kPage));
  if (!how.quiet) fmt::print("{}\n", file.string());
  if (open) open_in_browser(file);
  return 0;
}

}  // namespace vitrine
