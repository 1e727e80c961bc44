// vitrine edit PROJECT edits.yaml: applies edits to a finished scene and writes PROJECT/edited, with the program vitrine-edit.
#include <iostream>

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/config/cli.h"
#include "pipeline/project.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

void print_selections(const fs::path& report) {
  const auto json = nlohmann::json::parse(read_file(report));
  for (const auto& edit : json["edits"]) {
    const bool deleted = edit.contains("delete");
    std::string parts = fmt::format("{} surfels", edit.value("surfels", 0));
    if (const int behind = edit.value("surfels_behind_glass", 0)) parts += fmt::format(", {} behind glass", behind);
    if (const int faces = edit.value("mesh_faces", 0)) parts += fmt::format(", {} faces of the mesh", faces);
    fmt::print("{:<16} {} {}: {}\n", edit.value("name", ""), deleted ? "deleted" : "changed", edit.value("select", ""), parts);
  }
}

}  // namespace

int edit_command(const Words& words) {
  ToolOptions how;
  CommandLine cli(
      "vitrine edit", "PROJECT [EDITS.yaml] [options]",
      "Changes to a finished scene: materials by mask class, box, marks or component of the mesh; deletion. They go to "
      "PROJECT/edited, the originals stay; render, relight and export take --edited. Without a file: the edits of "
      "PROJECT/edited/edits.yaml once more. stages/edit/README.md shows the format.");
  add_usual_options(cli, how, "Files do");
  const Words rest = cli.parse(words, 2);
  if (how.help) {
    std::cout << cli.help();
    return 0;
  }
  if (rest.empty()) throw Error(ErrorKind::Usage, "which project?", {.hint = "vitrine edit PROJECT edits.yaml", .code = "USAGE"});
  const fs::path project = project_of(rest[0]);
  Words call;
  for (const Words& more : {work_words(how), quietness(how)}) call.insert(call.end(), more.begin(), more.end());
  const ProjectLock lock(project);
  const EditedScene edited = edited_scene(project, rest.size() == 2 ? fs::path(rest[1]) : fs::path(), call);
  if (edited.exit_code != 0) return edited.exit_code;
  if (how.quiet) return 0;
  print_selections(edited.folder / "report.json");
  fmt::print("{}\n", edited_folder(project).string());
  return 0;
}

}  // namespace vitrine
