#include "pipeline/tool.h"

#include <unistd.h>
#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"
#include "pipeline/graph.h"
#include "pipeline/project.h"

namespace vitrine {

namespace {

bool replaced_by_edits(const std::string& stage) { return stage == "optimize" || stage == "mesh" || stage == "decompose"; }

}  // namespace

void add_set_option(CommandLine& cli, ToolOptions& o, std::string_view tool) {
  cli.values("set", 0, "OPTION=VALUE", o.sets, fmt::format("An option of vitrine-{}.", tool));
}

void add_usual_options(CommandLine& cli, ToolOptions& o, std::string_view results) {
  cli.value("threads", 'j', "N", o.threads, 0, fmt::format("Threads; 0 = all. {} not depend on it.", results));
  cli.flag("no-progress", 0, o.no_progress, "No progress bar, no progress lines.");
  cli.flag("quiet", 'q', o.quiet, "Warnings and errors only.");
  cli.flag("help", 'h', o.help, "Print this text.");
}

const std::string& only_argument(const Words& rest, const char* question, const char* usage) {
  if (rest.size() != 1)
    throw Error(ErrorKind::Usage, rest.empty() ? std::string(question) : fmt::format("unexpected argument \"{}\"", rest[1]),
                {.hint = usage, .code = "USAGE"});
  return rest[0];
}

Words work_words(const ToolOptions& o) {
  Words words;
  for (const std::string& set : o.sets) words.insert(words.end(), {"--set", set});
  if (o.threads > 0) words.insert(words.end(), {"--threads", std::to_string(o.threads)});
  return words;
}

Words quietness(const ToolOptions& o) {
  Words words;
  if (o.no_progress) words.emplace_back("--no-progress");
  if (o.quiet) words.emplace_back("--quiet");
  return words;
}

int farm_command(const Words& words) {
  Words call{(own_folder() / "vitrine-farm").string()};
  call.insert(call.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (std::string& word : call) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  execv(arguments[0], arguments.data());  // in place of this process: signals of an engine reach the run
  throw Error(
      ErrorKind::Dependency, "vitrine-farm cannot be started",
      {.where = call[0], .why = std::strerror(errno), .hint = "build all of vitrine: cmake --build build", .code = "NO_PROGRAM"});
}

fs::path tool_program(const std::string& tool) {
  const fs::path program = stage_folder() / ("vitrine-" + tool);
  std::error_code ec;
  if (!fs::exists(program, ec))
    throw Error(ErrorKind::Dependency, fmt::format("the program vitrine-{} is missing", tool),
                {.where = program.string(), .hint = "build all of vitrine: cmake --build build", .code = "STAGE_MISSING"});
  return program;
}

Words tool_call(const std::string& tool, const fs::path& project, const ToolInputs& inputs) {
  const auto current = current_keys(project);
  for (const std::string& stage : inputs.stages) {
    if (current.contains(stage)) continue;
    if (is_composition(project))
      throw Error(ErrorKind::Input, inputs.missing,
                  {.where = project.string(),
                   .why = fmt::format("a part of this composition has no artifact of the stage '{}'", stage),
                   .hint = "vitrine run that part, then vitrine compose again",
                   .code = "PART_INCOMPLETE"});
    throw Error(ErrorKind::Input, inputs.missing,
                {.where = project.string(),
                 .why = fmt::format("the stage '{}' has not been computed", stage),
                 .hint = "vitrine run " + join_command({project.string()}),
                 .code = "NO_SCENE"});
  }
  Words words = {tool_program(tool).string(), "--store", store_of(project).string()};
  std::vector<std::string> stages = inputs.stages;
  std::ranges::copy_if(inputs.optional, std::back_inserter(stages), [&](const std::string& s) { return current.contains(s); });
  for (const std::string& stage : stages) {
    if (!inputs.edited.empty() && stage == "refine") continue;  // the edited surfels include the refinement
    const bool edited = !inputs.edited.empty() && replaced_by_edits(stage);
    const fs::path folder = edited ? inputs.edited : store_of(project) / stage / current.at(stage);
    words.insert(words.end(), {"--input", fmt::format("{}={}", stage, folder.string())});
  }
  return words;
}

int run_and_tell(const Words& words) {
  const ProcessResult result = run_process(
      {.arguments = words, .environment = {{"VITRINE_PARENT_PID", std::to_string(getpid())}}, .inherit_output = true});
  if (result.ok()) return 0;
  return result.signal != 0 ? exit_code(ErrorKind::Internal) : result.exit_code;
}

ToolResult run_tool(const std::string& tool, const fs::path& project, const Words& call, const Words& how) {
  ToolResult result{.key = key_of_run(call)};
  Words words = call;
  words.insert(words.end(), how.begin(), how.end());
  result.exit_code = run_and_tell(words);
  if (result.exit_code != 0) return result;
  const ArtifactStore store(store_of(project));
  auto manifest = store.find(tool, result.key);
  VITRINE_CHECK(manifest.has_value(), "vitrine-{} ended well but left no artifact {}", tool, result.key);
  result.manifest = std::move(*manifest);
  result.entry = store.entry(tool, result.key);
  return result;
}

EditedScene edited_scene(const fs::path& project, const fs::path& edits, const Words& how) {
  std::error_code ec;
  const bool replay = edits.empty();
  const fs::path file = replay ? edited_folder(project) / "edits.yaml" : fs::absolute(edits);
  if (!fs::is_regular_file(file, ec))
    throw Error(
        ErrorKind::Input, replay ? "this scene has no edits" : "there is no such file of edits",
        {.where = file.string(), .hint = "vitrine edit PROJECT edits.yaml", .code = replay ? "NO_EDITS" : "MISSING_INPUT"});
  Words call = tool_call("edit", project,
                         {.stages = {"sfm", "optimize", "mesh"},
                          .optional = {"refine", "decompose", "masks", "objects"},
                          .missing = "there is no scene to edit yet"});
  call.insert(call.end(), {"--input", "edits=" + file.string()});
  const ToolResult result = run_tool("edit", project, call, how);
  if (result.exit_code != 0) return {.exit_code = result.exit_code};
  const auto last = current_key(project, "edit");
  std::optional<Manifest> before;
  if (last && *last != result.key) before = ArtifactStore(store_of(project)).find("edit", *last);
  publish(result.entry, result.manifest, project, before ? &*before : nullptr);
  set_current_key(project, "edit", result.key);
  return {.folder = result.entry / "edited"};
}

void open_in_browser(const fs::path& page) {
  const auto opener = find_program("xdg-open");
  if (opener && run_and_tell({opener->string(), page.string()}) == 0) return;
  throw Error(ErrorKind::Dependency, "no program opens a browser here",
              {.why = opener ? "xdg-open found none" : "xdg-open is missing",
               .hint = "open the page by hand: " + page.string(),
               .code = "NO_BROWSER"});
}

}  // namespace vitrine
