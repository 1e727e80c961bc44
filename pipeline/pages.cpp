#include "pipeline/tool.h"

#include <unistd.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/artifact/store.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/process.h"
#include "pipeline/graph.h"

namespace vitrine {

namespace {

constexpr const char* kTool = "view";

// The path as typed in the current folder.
fs::path typed(const fs::path& project) {
  const fs::path here = project.lexically_relative(fs::current_path());
  return here.empty() || *here.begin() == ".." ? project : here;
}

}  // namespace

fs::path html_report_path(const fs::path& project) { return project / "report.html"; }

std::optional<std::string> write_html_report(const fs::path& project, bool only_if_changed) {
  const fs::path program = own_folder() / "vitrine-report";
  std::error_code ec;
  if (!fs::exists(program, ec)) return "the program vitrine-report is missing";
  std::vector<std::string> words = {program.string(), project.string(), "--typed", typed(project).string()};
  if (only_if_changed) words.push_back("--if-changed");
  try {
    const ProcessResult result =
        run_process({.arguments = words, .on_line = [](std::string_view) {}, .forward_interrupts = false});
    if (result.ok()) return std::nullopt;
    const std::string first = result.tail.substr(0, result.tail.find('\n'));
    return first.empty() ? fmt::format("vitrine-report ended with {}", result.signal != 0 ? "a signal" : "an error") : first;
  } catch (const Error& e) {  // the program cannot be started
    return e.message();
  }
}

fs::path view_page_path(const fs::path& project) { return project / "view.html"; }
fs::path relit_sample_path(const fs::path& project) { return project / "view_relit.jpg"; }

ToolInputs view_inputs(const fs::path& edited) {
  return {.stages = {"sfm", "optimize"},
          .optional = {"refine", "mesh", "decompose", "masks", "objects"},
          .missing = "there is no trained scene to view yet",
          .edited = edited};
}

void keep_view_page(const fs::path& project, const ToolResult& page) {
  const auto last = current_key(project, kTool);
  std::optional<Manifest> before;
  if (last && *last != page.key) before = ArtifactStore(store_of(project)).find(kTool, *last);
  publish(page.entry, page.manifest, project, before ? &*before : nullptr);
  set_current_key(project, kTool, page.key);
}

ViewPageOutcome write_view_page(const fs::path& project) {
  const auto current = current_keys(project);
  for (const std::string& stage : view_inputs().stages)
    if (!current.contains(stage)) return {};
  try {
    const Words call = tool_call(kTool, project, view_inputs());
    ToolResult page{.key = key_of_run(call)};
    Words words = call;
    words.insert(words.end(), {"--quiet", "--no-progress"});
    const ProcessResult r = run_process({.arguments = words,
                                         .environment = {{"VITRINE_PARENT_PID", std::to_string(getpid())}},
                                         .on_line = [](std::string_view) {},
                                         .forward_interrupts = false});
    if (!r.ok()) {
      const size_t error = r.tail.find("error: ");
      const std::string message = error == std::string::npos ? r.tail : r.tail.substr(error + 7);
      const std::string first = message.substr(0, message.find('\n'));
      return {ViewPage::Failed, first.empty() ? "vitrine-view ended without a word" : first};
    }
    const ArtifactStore store(store_of(project));
    const auto manifest = store.find(kTool, page.key);
    if (!manifest) return {ViewPage::Failed, "vitrine-view left nothing behind"};
    page.manifest = *manifest, page.entry = store.entry(kTool, page.key);
    keep_view_page(project, page);
    return {ViewPage::Written};
  } catch (const Error& e) {
    return {ViewPage::Failed, e.message()};
  }
}

}  // namespace vitrine
