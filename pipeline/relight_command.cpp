// vitrine relight PROJECT --env HDRI: pictures of the scene under another light, with the program vitrine-relight.
#include <iostream>

#include "pipeline/picture_tool.h"

namespace vitrine {

int relight_command(const Words& words) {
  PictureArguments a;
  std::string environment, lights, rotate, exposure;
  int turntable = 0, samples = 0;
  PictureTool tool{.name = "relight",
                   .folder = "relit",
                   .stages = {"sfm", "optimize", "mesh", "decompose"},
                   .missing = "this scene cannot be relit yet",
                   .words = {}};
  CommandLine cli(
      "vitrine relight", "[PROJECT] [options]",
      "Pictures of the scene under another light. PROJECT is the output folder of `vitrine run`; default: the current "
      "folder. Without --env and --lights: under the light of the photos.");
  cli.value("env", 'e', "FILE", environment, "Environment map: lat-long, 2:1, OpenEXR or Radiance HDR.");
  cli.value("lights", 0, "FILE", lights, "Point, directional and area lights: a YAML file (stages/relight/README.md).");
  cli.value("rotate", 0, "DEG", rotate, "Turn the environment about the vertical, counter-clockwise seen from above.");
  cli.value("turntable", 0, "N", turntable, 0, "N frames of a camera that goes around the scene, and a film if ffmpeg is there.");
  cli.value("spp", 0, "N", samples, 0, "Samples a pixel; default 64. Noise halves with four times as many.");
  cli.value("exposure", 0, "STOPS", exposure,
            "How many stops brighter the PNG are than the EXR; default: surfaces become middle grey.");
  add_picture_options(cli, a, tool);
  const Words rest = cli.parse(words, 1);
  if (a.help) {
    std::cout << cli.help();
    return 0;
  }
  const auto set = [&](const char* option, const std::string& value) {
    if (!value.empty()) tool.words.insert(tool.words.end(), {"--set", std::string(option) + "=" + value});
  };
  if (!environment.empty())
    add_input_file("env", environment, "a lat-long map as OpenEXR (.exr) or Radiance HDR (.hdr)", tool.words);
  if (!lights.empty()) add_input_file("lights", lights, "a YAML file of lights: stages/relight/README.md shows one", tool.words);
  set("rotate", rotate);
  set("exposure", exposure);
  if (!exposure.empty()) set("auto_exposure", "false");
  if (turntable > 0) set("turntable", std::to_string(turntable));
  if (samples > 0) set("samples", std::to_string(samples));
  return run_picture_tool(tool, picture_project(rest), a);
}

}  // namespace vitrine
