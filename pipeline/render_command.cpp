// vitrine render PROJECT: pictures of the trained scene. The work is done by the program vitrine-render, which stands beside the
// stages but not in their graph.
#include <unistd.h>

#include <charconv>
#include <iostream>

#include <nlohmann/json.hpp>

#include "core/artifact/current.h"
#include "core/artifact/publish.h"
#include "core/artifact/store.h"
#include "core/base/error.h"
#include "core/base/process.h"
#include "core/config/cli.h"
#include "pipeline/commands.h"
#include "pipeline/graph.h"
#include "pipeline/project.h"

namespace vitrine {

namespace {

struct RenderArguments {
  std::string output, views = "heldout", size;
  std::vector<std::string> sets;
  int threads = 0;
  bool layers = false, force = false, no_progress = false, quiet = false, help = false;
};

CommandLine render_command_line(RenderArguments& a) {
  CommandLine cli("vitrine render", "[PROJECT] [options]",
                  "Pictures of the trained scene. PROJECT is the output folder of `vitrine run`; default: the current folder.");
  cli.value("views", 0, "WHICH", a.views,
            "heldout, train, all, or a camera path: a file like the scene's transforms.json, in its frame.");
  cli.flag("layers", 'l', a.layers, "Also write what the pictures are made of, as EXR.");
  cli.value("size", 's', "WxH", a.size, "Size of the pictures; default: as trained, or as the path says.");
  cli.value("output", 'o', "DIR", a.output, "Where the folder `render` appears; default: PROJECT.");
  cli.values("set", 0, "OPTION=VALUE", a.sets, "An option of vitrine-render.");
  cli.flag("force", 0, a.force, "Render even if the pictures are in the store.");
  cli.value("threads", 'j', "N", a.threads, 0, "Threads; 0 = all. Pictures do not depend on it.");
  cli.flag("no-progress", 0, a.no_progress, "No progress bar, no progress lines.");
  cli.flag("quiet", 'q', a.quiet, "Warnings and errors only.");
  cli.flag("help", 'h', a.help, "Print this text.");
  return cli;
}

void add_size(const std::string& size, Words& words) {
  int width = 0, height = 0;
  const char *begin = size.data(), *end = begin + size.size();
  const auto w = std::from_chars(begin, end, width);
  const auto h = w.ec == std::errc() && w.ptr != end && *w.ptr == 'x' ? std::from_chars(w.ptr + 1, end, height) : w;
  if (h.ec != std::errc() || h.ptr != end || width < 1 || height < 1)
    throw Error(ErrorKind::Usage, fmt::format("--size must look like 1280x720, got \"{}\"", size), {.code = "USAGE"});
  words.insert(words.end(), {"--set", fmt::format("width={}", width), "--set", fmt::format("height={}", height)});
}

void add_views(const std::string& views, Words& words) {
  const bool named = views == "heldout" || views == "train" || views == "all";
  words.insert(words.end(), {"--set", "views=" + (named ? views : "path")});
  if (named) return;
  std::error_code ec;
  if (!fs::is_regular_file(views, ec))
    throw Error(ErrorKind::Input, "there is no such camera path",
                {.where = views, .hint = "--views heldout, train, all, or a file like transforms.json", .code = "MISSING_INPUT"});
  words.insert(words.end(), {"--input", "path=" + fs::absolute(views).string()});
}

std::string key_of_run(const Words& words) {
  Words ask = words;
  ask.push_back("--print-key");
  std::string text;
  const ProcessResult r = run_process({.arguments = ask, .on_line = [&](std::string_view line) { text.append(line) += "\n"; }});
  const auto json = nlohmann::json::parse(text, nullptr, false);
  return r.ok() && json.is_object() ? json.value("key", "") : "";
}

}  // namespace

int render_command(const Words& words) {
  RenderArguments a;
  const CommandLine cli = render_command_line(a);
  const Words rest = cli.parse(words);
  if (a.help) {
    std::cout << cli.help();
    return 0;
  }
  if (rest.size() > 1) throw Error(ErrorKind::Usage, fmt::format("unexpected argument \"{}\"", rest[1]), {.code = "USAGE"});
  const fs::path project = project_of(rest.empty() ? "." : rest[0]);
  const auto current = current_keys(project);
  for (const char* stage : {"sfm", "optimize"})
    if (!current.contains(stage))
      throw Error(ErrorKind::Input, "there is no trained scene yet",
                  {.where = project.string(),
                   .why = fmt::format("the stage '{}' has not been computed", stage),
                   .hint = "vitrine run " + join_command({project.string()}),
                   .code = "NO_SCENE"});
  const fs::path program = stage_folder() / "vitrine-render";
  std::error_code ec;
  if (!fs::exists(program, ec))
    throw Error(ErrorKind::Dependency, "the program vitrine-render is missing",
                {.where = program.string(), .hint = "build all of vitrine: cmake --build build", .code = "STAGE_MISSING"});

  Words run = {program.string(), "--store", store_of(project).string()};
  for (const char* stage : {"sfm", "optimize"})
    run.insert(run.end(), {"--input", fmt::format("{}={}", stage, (store_of(project) / stage / current.at(stage)).string())});
  add_views(a.views, run);
  if (a.layers) run.insert(run.end(), {"--set", "layers=true"});
  if (!a.size.empty()) add_size(a.size, run);
  for (const std::string& set : a.sets) run.insert(run.end(), {"--set", set});
  if (a.threads > 0) run.insert(run.end(), {"--threads", std::to_string(a.threads)});

  const ProjectLock lock(project);
  const std::string key = key_of_run(run);
  if (a.force) run.push_back("--force");
  if (a.no_progress) run.push_back("--no-progress");
  if (a.quiet) run.push_back("--quiet");
  // It tells its own errors.
  const ProcessResult result =
      run_process({.arguments = run, .environment = {{"VITRINE_PARENT_PID", std::to_string(getpid())}}, .inherit_output = true});
  if (!result.ok()) return result.signal != 0 ? exit_code(ErrorKind::Internal) : result.exit_code;

  ArtifactStore store(store_of(project));
  const auto manifest = store.find("render", key);
  VITRINE_CHECK(manifest.has_value(), "vitrine-render ended well but left no artifact {}", key);
  const fs::path target = a.output.empty() ? project : fs::absolute(a.output).lexically_normal();
  std::optional<Manifest> before;  // pictures of the last call make room
  if (const auto last = current.find("render"); target == project && last != current.end() && last->second != key)
    before = store.find("render", last->second);
  publish(store.entry("render", key), *manifest, target, before ? &*before : nullptr);
  if (target == project) set_current_key(project, "render", key);
  if (!a.quiet) fmt::print("{}\n", (target / "render").string());
  return 0;
}

}  // namespace vitrine
