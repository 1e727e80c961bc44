#include "pipeline/picture_tool.h"

#include <unistd.h>

#include <charconv>

#include "core/artifact/current.h"
#include "core/artifact/publish.h"
#include "core/artifact/store.h"
#include "core/base/error.h"
#include "core/base/process.h"
#include "pipeline/graph.h"
#include "pipeline/printed_key.h"
#include "pipeline/project.h"

namespace vitrine {

namespace {

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
  if (!named) add_input_file("path", views, "--views heldout, train, all, or a file like transforms.json", words);
}

// The folder with the cameras of the pictures.
fs::path pictures_folder(const Manifest& manifest) {
  for (const OutputFile& file : manifest.outputs)
    if (const fs::path path(file.path); path.filename() == "transforms.json") return path.parent_path();
  return {};
}

// Files of the last call in the same folder make room for those of this one; pictures in other folders stay.
std::optional<Manifest> pictures_before(ArtifactStore& store, const std::string& tool, const std::string& key,
                                        const Manifest& now) {
  std::optional<Manifest> before = store.find(tool, key);
  return before && pictures_folder(*before) == pictures_folder(now) ? before : std::nullopt;
}

}  // namespace

void add_picture_options(CommandLine& cli, PictureArguments& a, const std::string& folder) {
  cli.value("views", 0, "WHICH", a.views,
            "heldout, train, all, or a camera path: a file like the scene's transforms.json, in its frame.");
  cli.value("size", 's', "WxH", a.size, "Size of the pictures; default: as trained, or as the path says.");
  cli.value("output", 'o', "DIR", a.output, fmt::format("Where the folder `{}` appears; default: PROJECT.", folder));
  cli.values("set", 0, "OPTION=VALUE", a.sets, fmt::format("An option of vitrine-{}.", folder));
  cli.flag("force", 0, a.force, "Compute the pictures even if they are in the store.");
  cli.value("threads", 'j', "N", a.threads, 0, "Threads; 0 = all. Pictures do not depend on it.");
  cli.flag("no-progress", 0, a.no_progress, "No progress bar, no progress lines.");
  cli.flag("quiet", 'q', a.quiet, "Warnings and errors only.");
  cli.flag("help", 'h', a.help, "Print this text.");
}

fs::path picture_project(const Words& rest) { return project_of(rest.empty() ? "." : rest[0]); }

void add_input_file(const std::string& name, const std::string& path, const std::string& hint, Words& words) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec))
    throw Error(ErrorKind::Input, fmt::format("there is no such {}", name == "path" ? "camera path" : "file"),
                {.where = path, .hint = hint, .code = "MISSING_INPUT"});
  words.insert(words.end(), {"--input", name + "=" + fs::absolute(path).string()});
}

int run_picture_tool(const PictureTool& tool, const fs::path& project, const PictureArguments& a) {
  const auto current = current_keys(project);
  for (const std::string& stage : tool.stages)
    if (!current.contains(stage))
      throw Error(ErrorKind::Input, tool.missing,
                  {.where = project.string(),
                   .why = fmt::format("the stage '{}' has not been computed", stage),
                   .hint = "vitrine run " + join_command({project.string()}),
                   .code = "NO_SCENE"});
  const fs::path program = stage_folder() / ("vitrine-" + tool.name);
  std::error_code ec;
  if (!fs::exists(program, ec))
    throw Error(ErrorKind::Dependency, fmt::format("the program vitrine-{} is missing", tool.name),
                {.where = program.string(), .hint = "build all of vitrine: cmake --build build", .code = "STAGE_MISSING"});

  Words run = {program.string(), "--store", store_of(project).string()};
  for (const auto& stages : {tool.stages, tool.optional_stages})
    for (const std::string& stage : stages)
      if (const auto key = current.find(stage); key != current.end())
        run.insert(run.end(), {"--input", fmt::format("{}={}", stage, (store_of(project) / stage / key->second).string())});
  add_views(a.views, run);
  if (!a.size.empty()) add_size(a.size, run);
  run.insert(run.end(), tool.words.begin(), tool.words.end());
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
  const auto manifest = store.find(tool.name, key);
  VITRINE_CHECK(manifest.has_value(), "vitrine-{} ended well but left no artifact {}", tool.name, key);
  const fs::path target = a.output.empty() ? project : fs::absolute(a.output).lexically_normal();
  std::optional<Manifest> before;
  if (const auto last = current.find(tool.name); target == project && last != current.end() && last->second != key)
    before = pictures_before(store, tool.name, last->second, *manifest);
  publish(store.entry(tool.name, key), *manifest, target, before ? &*before : nullptr);
  if (target == project) set_current_key(project, tool.name, key);
  if (!a.quiet) fmt::print("{}\n", (target / tool.name).string());
  return 0;
}

}  // namespace vitrine
