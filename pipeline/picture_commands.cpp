// vitrine render PROJECT: pictures of the trained scene, with the program vitrine-render; vitrine relight PROJECT --env HDRI:
// pictures under another light, with the program vitrine-relight. The pictures are linked into the output folder.
#include <charconv>
#include <iostream>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/cli.h"
#include "pipeline/commands.h"
#include "pipeline/project.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

struct PictureArguments : ToolOptions {
  std::string output, views = "heldout", size, frames;
  bool edited = false, force = false;
};
struct PictureTool {
  std::string name;                                       // "render": runs vitrine-render; also its folder in the store
  std::string folder;                                     // folder of the pictures
  std::vector<std::string> stages;                        // required artifacts
  std::vector<std::string> optional_stages = {"refine"};  // optional artifacts
  std::string missing;                                    // error message: "there is no trained scene yet"
  Words words;                                            // additional arguments of the program
};

void add_size(const std::string& size, Words& words) {
  int width = 0, height = 0;
  const char *begin = size.data(), *end = begin + size.size();
  const auto w = std::from_chars(begin, end, width);
  const auto h = w.ec == std::errc() && w.ptr != end && *w.ptr == 'x' ? std::from_chars(w.ptr + 1, end, height) : w;
  if (h.ec != std::errc() || h.ptr != end || width < 1 || height < 1)
    throw Error(ErrorKind::Usage, fmt::format("--size must look like 1280x720, got \"{}\"", size),
                {.hint = "--size 1280x720", .code = "USAGE"});
  words.insert(words.end(), {"--set", fmt::format("width={}", width), "--set", fmt::format("height={}", height)});
}

// Adds --input NAME=PATH for a file of the user. Throws Error{Input} if it does not exist.
void add_input_file(const std::string& name, const std::string& path, const std::string& hint, Words& words) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec))
    throw Error(ErrorKind::Input, fmt::format("there is no such {}", name == "path" ? "camera path" : "file"),
                {.where = path, .hint = hint, .code = "MISSING_INPUT"});
  words.insert(words.end(), {"--input", name + "=" + fs::absolute(path).string()});
}

void add_views(const std::string& views, Words& words) {
  const bool named = views == "heldout" || views == "train" || views == "all";
  words.insert(words.end(), {"--set", "views=" + (named ? views : "path")});
  if (!named) add_input_file("path", views, "--views heldout, train, all, or a file like transforms.json", words);
}

// Folder that contains transforms.json.
fs::path pictures_folder(const Manifest& manifest) {
  for (const OutputFile& file : manifest.outputs)
    if (const fs::path path(file.path); path.filename() == "transforms.json") return path.parent_path();
  return {};
}

// The manifest of the last call with the same picture folder: its files are replaced; pictures in other folders stay.
std::optional<Manifest> pictures_before(ArtifactStore& store, const std::string& tool, const std::string& key,
                                        const Manifest& now) {
  std::optional<Manifest> before = store.find(tool, key);
  return before && pictures_folder(*before) == pictures_folder(now) ? before : std::nullopt;
}

void add_picture_options(CommandLine& cli, PictureArguments& a, const PictureTool& tool) {
  cli.value("views", 0, "WHICH", a.views,
            "heldout, train, all, or a camera path: a file like the scene's transforms.json, in its frame.");
  cli.value("size", 's', "WxH", a.size, "Size of the pictures; default: as trained, or as in the path.");
  cli.value("frames", 0, "A-B", a.frames,
            "Only these of the pictures, numbered from 0: 10-19, or 7. Other machines make the others; the same command without "
            "--frames takes what is in the store.");
  cli.value("output", 'o', "DIR", a.output, fmt::format("Where the folder `{}` appears; default: PROJECT.", tool.folder));
  add_set_option(cli, a, tool.name);
  cli.flag("edited", 0, a.edited, fmt::format("The scene with its edits (vitrine edit), into PROJECT/edited/{}.", tool.folder));
  cli.flag("force", 0, a.force, "Compute the pictures even if they are in the store.");
  add_usual_options(cli, a, "Pictures do");
}

// The project folder among the remaining command-line words, or the current folder.
fs::path picture_project(const Words& rest) { return project_of(rest.empty() ? "." : rest[0]); }

int run_picture_tool(const PictureTool& tool, const fs::path& project, const PictureArguments& a) {
  const bool part = !a.frames.empty();
  const ProjectLock lock(project, part && !a.edited ? LockKind::Shared : LockKind::Exclusive);
  const fs::path there = a.edited ? edited_folder(project) : project;
  const fs::path target = result_folder(project, there, a.output);
  Words how = quietness(a);
  ToolInputs inputs{.stages = tool.stages, .optional = tool.optional_stages, .missing = tool.missing};
  if (a.edited) {
    const EditedScene edited = edited_scene(project, {}, how);
    if (edited.exit_code != 0) return edited.exit_code;
    inputs.edited = edited.folder;
  }
  Words run = tool_call(tool.name, project, inputs);
  add_views(a.views, run);
  if (!a.size.empty()) add_size(a.size, run);
  if (part) run.insert(run.end(), {"--set", "frames=" + a.frames});
  run.insert(run.end(), tool.words.begin(), tool.words.end());
  const Words work = work_words(a);
  run.insert(run.end(), work.begin(), work.end());

  if (a.force) how.emplace_back("--force");
  const ToolResult result = run_tool(tool.name, project, run, how);
  if (result.exit_code != 0) return result.exit_code;

  // Parts of one list fall together in the folder: none replaces another, and none is the current result.
  if (part) {
    const PublishingLock others(project);
    publish(result.entry, result.manifest, target);
    if (!a.quiet)
      fmt::print(
          "{}\nnote: these are frames {} alone; when the others are there, too, the same command without --frames takes them "
          "all from the store{}\n",
          (target / tool.folder).string(), a.frames, tool.name == "relight" ? ", and makes the film" : "");
    return 0;
  }
  // Separate records of the pictures in the project and in PROJECT/edited.
  const std::string role = a.edited ? tool.name + "-edited" : tool.name;
  ArtifactStore store(store_of(project));
  std::optional<Manifest> before;
  if (const auto last = current_key(project, role); target == there && last && *last != result.key)
    before = pictures_before(store, tool.name, *last, result.manifest);
  publish(result.entry, result.manifest, target, before ? &*before : nullptr);
  if (target == there) set_current_key(project, role, result.key);
  if (!a.quiet) fmt::print("{}\n", (target / tool.folder).string());
  // The report shows relit pictures: update it. A folder without a report gets one from its next run.
  if (tool.name == "relight" && target == there && fs::exists(html_report_path(project))) {
    const auto why_not = write_html_report(project, true);
    if (why_not && !a.quiet) fmt::print("note: report.html does not show these pictures yet: {}\n", *why_not);
  }
  return 0;
}

}  // namespace

int render_command(const Words& words) {
  PictureArguments a;
  std::string camera, device;
  bool layers = false, without_medium = false;
  PictureTool tool{.name = "render",
                   .folder = "render",
                   .stages = {"sfm", "optimize"},
                   .missing = "there is no trained scene yet",
                   .words = {}};
  CommandLine cli("vitrine render", "[PROJECT] [options]",
                  "Pictures of the trained scene. PROJECT is the output folder of `vitrine run`; default: the current folder.");
  cli.value("camera", 0, "KIND", camera,
            "perspective, or equirect: the whole sphere around each camera, 2:1; default: perspective.");
  cli.value("device", 0, "cpu|cuda|auto", device, "Where pictures are computed; auto: a GPU where one is usable.");
  cli.flag("layers", 'l', layers, "Also write what the pictures are made of, as EXR.");
  cli.flag("without-medium", 0, without_medium, "Without the water or haze of the photos.");
  add_picture_options(cli, a, tool);
  const Words rest = cli.parse(words, 1);
  if (a.help) {
    std::cout << cli.help();
    return 0;
  }
  if (layers) tool.words = {"--set", "layers=true"};
  if (without_medium) tool.words.insert(tool.words.end(), {"--set", "without_medium=true"});
  if (!device.empty()) tool.words.insert(tool.words.end(), {"--device", device});
  if (!camera.empty()) tool.words.insert(tool.words.end(), {"--set", "camera=" + camera});
  return run_picture_tool(tool, picture_project(rest), a);
}

int relight_command(const Words& words) {
  PictureArguments a;
  std::string environment, lights, rotate, exposure, over;
  int turntable = 0, samples = 0;
  PictureTool tool{.name = "relight",
                   .folder = "relit",
                   .stages = {"sfm", "optimize", "mesh", "decompose"},
                   .optional_stages = {"refine", "compose"},
                   .missing = "this scene cannot be relit yet",
                   .words = {}};
  CommandLine cli(
      "vitrine relight", "[PROJECT] [options]",
      "Pictures of the scene under another light. PROJECT is the output folder of `vitrine run`; default: the current "
      "folder. Without --env and --lights: under the light of the photos.");
  cli.value("env", 'e', "FILE", environment, "Environment map: lat-long, 2:1, OpenEXR or Radiance HDR.");
  cli.value("lights", 0, "FILE", lights, "Point, directional and area lights: a YAML file (stages/relight/README.md).");
  cli.value("over", 0, "PHOTO", over,
            "A photo of a composition's first part: the other parts and their shadow over it, as RGBA EXR (vitrine compose).");
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
  set("over", over);
  set("rotate", rotate);
  set("exposure", exposure);
  if (!exposure.empty()) set("auto_exposure", "false");
  if (turntable > 0) set("turntable", std::to_string(turntable));
  if (samples > 0) set("samples", std::to_string(samples));
  return run_picture_tool(tool, picture_project(rest), a);
}

}  // namespace vitrine
