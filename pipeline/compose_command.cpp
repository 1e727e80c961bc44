// vitrine compose SCENE.yaml -o DIR: several finished scenes in one, with the program vitrine-compose. Its artifact is split into
// artifacts of the stages that usually write these files, and those of the first part (cameras, photos, masks) are added: all
// other commands take the folder for one of `vitrine run`.
#include <algorithm>
#include <iostream>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/json.h"
#include "core/foundation/config/cli.h"
#include "core/foundation/config/yaml.h"
#include "pipeline/project.h"
#include "pipeline/tool.h"

namespace vitrine {

namespace {

constexpr const char* kTool = "compose";
constexpr const char* kUsage = "vitrine compose SCENE.yaml -o DIR";

struct Share {
  const char* stage;
  std::vector<std::string_view> folders;  // of the files that this stage usually writes
};
const std::vector<Share>& shares() {
  static const std::vector<Share> all{
      {"optimize", {"gaussians/", "optimize/"}}, {"mesh", {"mesh/"}}, {"decompose", {"decompose/"}}, {"objects", {"objects/"}}};
  return all;
}

// Projects that the list names, in order; vitrine-compose reports mistakes in it.
std::vector<fs::path> projects_of(const fs::path& file) {
  std::vector<fs::path> out;
  const YamlFile yaml = read_yaml(file.string());
  const YamlNode* parts = yaml.root.kind == YamlNode::Kind::Map ? yaml.root.find("parts") : nullptr;
  if (parts == nullptr) return out;
  for (const YamlNode& part : parts->items)
    if (const YamlNode* project = part.kind == YamlNode::Kind::Map ? part.find("project") : nullptr)
      out.push_back((file.parent_path() / project->text).lexically_normal());
  return out;
}

// The folder must be free, or a composition, which is replaced.
void check_output(const fs::path& out, const std::vector<fs::path>& projects) {
  for (const fs::path& project : projects)
    if (lies_in(out, project) && lies_in(project, out))
      throw Error(ErrorKind::Usage, "the output folder is one of the parts",
                  {.where = out.string(), .hint = "choose another one with -o", .code = "USAGE"});
  std::error_code ec;
  if (!fs::exists(out, ec) || is_composition(out) || (fs::is_directory(out, ec) && fs::is_empty(out, ec))) return;
  throw Error(ErrorKind::Usage, "the output folder contains other files",
              {.where = out.string(),
               .why = is_project(out) ? "it is the output folder of a run" : "it was not made by vitrine compose",
               .hint = "choose another one with -o",
               .code = "USAGE"});
}

// Removes what a failed command has written into a folder that was missing or empty.
class CleanedFolder {
 public:
  explicit CleanedFolder(fs::path folder)
      : folder_(std::move(folder)), there_(fs::exists(folder_)), free_(!is_composition(folder_)) {
    make_folders(store_of(folder_));
  }
  CleanedFolder(const CleanedFolder&) = delete;
  CleanedFolder& operator=(const CleanedFolder&) = delete;
  ~CleanedFolder() {
    std::error_code ec;
    if (kept || !free_) return;
    if (!there_) {
      fs::remove_all(folder_, ec);
      return;
    }
    for (const auto& e : fs::directory_iterator(folder_, ec)) fs::remove_all(e.path(), ec);
  }
  bool kept = false;

 private:
  fs::path folder_;
  bool there_, free_;
};

// Makes files of `entry` the current artifact of a stage of the project and links them into its folder.
void keep_artifact(const fs::path& project, const std::string& stage, const fs::path& entry, Manifest manifest) {
  ArtifactStore store(store_of(project));
  const auto last = current_key(project, stage);
  const auto before = last ? store.find(stage, *last) : std::nullopt;
  manifest.stage = stage;
  PendingArtifact pending(store, stage, manifest.key);
  publish(entry, manifest, pending.path());
  const fs::path made = pending.commit(manifest, "{}\n");
  publish(made, manifest, project, before ? &*before : nullptr);
  set_current_key(project, stage, manifest.key);
}

void drop_artifact(const fs::path& project, const std::string& stage) {
  const auto last = current_key(project, stage);
  if (!last) return;
  ArtifactStore store(store_of(project));
  const auto before = store.find(stage, *last);
  Manifest nothing;
  if (before) publish(project, nothing, project, &*before);
  remove_current_key(project, stage);
}

void keep_composition(const fs::path& project, const fs::path& host, const ToolResult& result) {
  for (const Share& share : shares()) {
    Manifest part = result.manifest;
    std::erase_if(part.outputs, [&](const OutputFile& f) {
      return std::ranges::none_of(share.folders, [&](std::string_view folder) { return f.path.starts_with(folder); });
    });
    if (part.outputs.empty())
      drop_artifact(project, share.stage);
    else
      keep_artifact(project, share.stage, result.entry, std::move(part));
  }
  for (const char* stage : {"sfm", "masks"}) {
    const auto key = current_key(host, stage);
    const ArtifactStore store(store_of(host));
    const auto manifest = key ? store.find(stage, *key) : std::nullopt;
    if (manifest)
      keep_artifact(project, stage, store.entry(stage, *key), *manifest);
    else
      drop_artifact(project, stage);
  }
  if (current_key(project, kTool) != result.key) drop_artifact(project, "view");  // it shows the composition before
  set_current_key(project, kTool, result.key);
}

void print_parts(const fs::path& report) {
  const auto json = nlohmann::json::parse(read_file(report));
  for (const auto& part : json.at("parts"))
    fmt::print("{:<16} {}: {} surfels, {} faces of the mesh, scale {:.4g}\n", part.at("name").get<std::string>(),
               part.at("select").get<std::string>(), part.at("surfels").get<size_t>(), part.at("mesh_faces").get<size_t>(),
               part.at("scale").get<double>());
}

}  // namespace

bool is_composition(const fs::path& folder) { return is_project(folder) && current_key(folder, kTool).has_value(); }

int compose_command(const Words& words) {
  ToolOptions how;
  std::string output;
  CommandLine cli(
      "vitrine compose", "SCENE.yaml -o DIR [options]",
      "Several finished scenes, or objects of them, in one: the list names output folders of `vitrine run`, what to take, "
      "and its place. DIR is then a folder that render, relight, view, edit and export take. stages/compose/README.md "
      "shows the format.");
  cli.value("output", 'o', "DIR", output, "Output folder: missing, empty, or of an earlier composition, which it replaces.");
  add_usual_options(cli, how, "Files do");
  const Words rest = cli.parse(words, 1);
  if (how.help) {
    std::cout << cli.help();
    return 0;
  }
  const fs::path file = fs::absolute(only_argument(rest, "which scenes?", kUsage)).lexically_normal();
  if (output.empty()) throw Error(ErrorKind::Usage, "where does the composition go?", {.hint = kUsage, .code = "USAGE"});
  std::error_code ec;
  if (!fs::is_regular_file(file, ec))
    throw Error(ErrorKind::Input, "there is no such list of scenes",
                {.where = file.string(), .hint = kUsage, .code = "MISSING_INPUT"});
  const fs::path project = fs::absolute(output).lexically_normal();
  const std::vector<fs::path> projects = projects_of(file);
  check_output(project, projects);
  const fs::path program = tool_program(kTool);
  CleanedFolder folder(project);
  const ProjectLock lock(project);
  Words call{program.string(), "--store", store_of(project).string(), "--input", "scene=" + file.string()};
  const Words work = work_words(how);
  call.insert(call.end(), work.begin(), work.end());
  const ToolResult result = run_tool(kTool, project, call, quietness(how));
  if (result.exit_code != 0) return result.exit_code;
  keep_composition(project, projects.front(), result);
  write_file(project / "vitrine.yaml", "# A composition: `vitrine compose` makes it, not `vitrine run`.\n");
  folder.kept = true;
  if (how.quiet) return 0;
  print_parts(result.entry / "compose/report.json");
  fmt::print("{}\n", project.string());
  return 0;
}

}  // namespace vitrine
