#include "pipeline/picture_tool.h"

#include <charconv>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"
#include "pipeline/html_report.h"
#include "pipeline/project.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

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

}  // namespace

void add_picture_options(CommandLine& cli, PictureArguments& a, const PictureTool& tool) {
  cli.value("views", 0, "WHICH", a.views,
            "heldout, train, all, or a camera path: a file like the scene's transforms.json, in its frame.");
  cli.value("size", 's', "WxH", a.size, "Size of the pictures; default: as trained, or as the path says.");
  cli.value("output", 'o', "DIR", a.output, fmt::format("Where the folder `{}` appears; default: PROJECT.", tool.folder));
  add_set_option(cli, a, tool.name);
  cli.flag("edited", 0, a.edited, fmt::format("The scene with its edits (vitrine edit), into PROJECT/edited/{}.", tool.folder));
  cli.flag("force", 0, a.force, "Compute the pictures even if they are in the store.");
  add_usual_options(cli, a, "Pictures do");
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
  const ProjectLock lock(project);
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
  run.insert(run.end(), tool.words.begin(), tool.words.end());
  const Words work = work_words(a);
  run.insert(run.end(), work.begin(), work.end());

  if (a.force) how.emplace_back("--force");
  const ToolResult result = run_tool(tool.name, project, run, how);
  if (result.exit_code != 0) return result.exit_code;

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

}  // namespace vitrine
