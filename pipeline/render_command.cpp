// vitrine render PROJECT: pictures of the trained scene, with the program vitrine-render.
#include <iostream>

#include "pipeline/picture_tool.h"

namespace vitrine {

int render_command(const Words& words) {
  PictureArguments a;
  bool layers = false;
  PictureTool tool{.name = "render",
                   .folder = "render",
                   .stages = {"sfm", "optimize"},
                   .missing = "there is no trained scene yet",
                   .words = {}};
  CommandLine cli("vitrine render", "[PROJECT] [options]",
                  "Pictures of the trained scene. PROJECT is the output folder of `vitrine run`; default: the current folder.");
  cli.flag("layers", 'l', layers, "Also write what the pictures are made of, as EXR.");
  add_picture_options(cli, a, tool);
  const Words rest = cli.parse(words, 1);
  if (a.help) {
    std::cout << cli.help();
    return 0;
  }
  if (layers) tool.words = {"--set", "layers=true"};
  return run_picture_tool(tool, picture_project(rest), a);
}

}  // namespace vitrine
