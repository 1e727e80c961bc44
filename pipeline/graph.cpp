#include "pipeline/graph.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include "core/foundation/base/error.h"
#include "core/foundation/base/graphics_card.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/text.h"

namespace vitrine {

using nlohmann::json;

namespace {

// Reads the description that the build stored (vitrine-<stage>.json), since starting ten programs with all their libraries takes
// a second. Empty if it is older than the program or not JSON.
std::string written_description(const fs::path& executable) {
  const fs::path file = executable.string() + ".json";
  std::error_code ec;
  const auto written = fs::last_write_time(file, ec);
  if (ec || written < fs::last_write_time(executable, ec) || ec) return {};
  std::string text = read_file(file);
  return json::parse(text, nullptr, false).is_object() ? text : std::string();
}

StageNode describe_stage(const fs::path& executable, const std::string& name) {
  std::error_code ec;
  if (!fs::exists(executable, ec))
    throw Error(ErrorKind::Dependency, fmt::format("the program of stage '{}' is missing", name),
                {.where = executable.string(), .hint = "build all of vitrine: cmake --build build", .code = "STAGE_MISSING"});
  StageNode node;
  ProcessResult r;
  node.description = written_description(executable);
  if (node.description.empty()) {
    r = run_process({.arguments = {executable.string(), "--describe"},
                     .on_line = [&](std::string_view line) { node.description += std::string(line) + "\n"; }});
    throw_if_interrupted();
    if (r.signal != 0) throw_ended_by_signal(name, r);
  }
  const json d = json::parse(node.description, nullptr, false);
  if (!r.ok() || !d.is_object() || d.value("format", 0) != 1)
    throw Error(ErrorKind::Dependency, fmt::format("the program of stage '{}' does not describe itself", name),
                {.where = executable.string(),
                 .why = r.tail,
                 .hint = "build all of vitrine from the same sources",
                 .code = "STAGE_BROKEN"});
  node.name = d.at("name");
  node.summary = d.at("summary");
  node.version = d.at("version");
  node.executable = executable;
  for (const json& i : d.at("inputs"))
    node.inputs.push_back(
        {i.at("name"), i.at("artifact"), i.at("optional"), i.at("doc"), i.value("skips", std::vector<std::string>())});
  if (d.contains("report")) node.report = parse_stage_report(d["report"].dump());
  node.doing = d.value("doing", "");
  node.has_cost = d.value("has_cost", false);
  node.devices = d.value("devices", std::vector<std::string>());
  return node;
}

}  // namespace

void throw_ended_by_signal(std::string_view stage, const ProcessResult& result) {
  if (result.signal == SIGKILL)
    throw Error(ErrorKind::Resource, fmt::format("stage '{}' was killed", stage),
                {.why = "the system ends a process like this when memory runs out",
                 .hint = "a smaller preset, --max-memory, or fewer photos; then the same command again",
                 .code = "KILLED"});
  throw Error(ErrorKind::Internal,
              fmt::format("stage '{}' ended by signal {} ({})", stage, result.signal, strsignal(result.signal)),
              {.why = result.tail,
               .hint = "this is a bug in vitrine: please report it with run.json and log.txt",
               .code = "STAGE_CRASHED"});
}

const StageNode& Graph::at(std::string_view name) const {
  std::vector<std::string> names;
  for (const StageNode& n : nodes) {
    if (n.name == name) return n;
    names.push_back(n.name);
  }
  const std::string near = nearest_word(name, names);
  throw Error(
      ErrorKind::Usage,
      fmt::format("there is no stage '{}'{}", name, near.empty() ? std::string() : fmt::format("; did you mean '{}'?", near)),
      {.why = fmt::format("the stages are: {}", fmt::join(names, " ")), .hint = "vitrine run --help", .code = "NO_SUCH_STAGE"});
}

std::set<std::string> Graph::ancestors(const StageNode& node) const {
  std::set<std::string> found;
  for (const NodeInput& input : node.inputs) {
    if (!input.artifact) continue;
    for (const StageNode& n : nodes) {
      if (n.name != input.name) continue;
      found.insert(n.name);
      found.merge(ancestors(n));
    }
  }
  return found;
}

std::set<std::string> Graph::descendants(const StageNode& node) const {
  std::set<std::string> found;
  for (const StageNode& n : nodes)
    if (ancestors(n).contains(node.name)) found.insert(n.name);
  return found;
}

std::vector<NodeInput> Graph::outside_inputs() const {
  std::vector<NodeInput> all;
  for (const StageNode& n : nodes)
    for (const NodeInput& input : n.inputs) {
      const bool known = std::any_of(all.begin(), all.end(), [&](const NodeInput& i) { return i.name == input.name; });
      if (!input.artifact && !known) all.push_back(input);
    }
  return all;
}

bool has_device_kernels(const Graph& graph) {
  return std::ranges::any_of(graph.nodes, [](const StageNode& n) { return std::ranges::count(n.devices, "cuda") > 0; });
}

std::string why_no_device(const Graph& graph) {
  if (!has_device_kernels(graph)) return "this build has no kernels for a GPU (there was no nvcc)";
  return find_graphics_card().why_not;
}

fs::path own_folder() { return fs::read_symlink("/proc/self/exe").parent_path(); }

fs::path stage_folder() {
  const char* chosen = std::getenv("VITRINE_STAGE_DIR");
  return chosen != nullptr && *chosen != 0 ? fs::path(chosen) : own_folder();
}

Graph load_graph(const fs::path& folder) {
  const fs::path list = folder / "vitrine.stages";
  std::error_code ec;
  if (!fs::exists(list, ec))
    throw Error(ErrorKind::Dependency, "the list of stages is missing",
                {.where = list.string(),
                 .hint = "run vitrine from its build or installation folder, or set VITRINE_STAGE_DIR",
                 .code = "STAGE_MISSING"});
  std::istringstream lines(read_file(list));
  std::vector<StageNode> waiting;
  for (std::string name; lines >> name;) waiting.push_back(describe_stage(folder / ("vitrine-" + name), name));
  // Drops optional inputs whose stage is not in the pipeline.
  for (StageNode& node : waiting)
    std::erase_if(node.inputs, [&](const NodeInput& i) {
      return i.artifact && i.optional &&
             std::none_of(waiting.begin(), waiting.end(), [&](const StageNode& n) { return n.name == i.name; });
    });
  // Topological sort; ties keep the order of the list.
  Graph graph;
  const auto placed = [&](const std::string& name) {
    return std::any_of(graph.nodes.begin(), graph.nodes.end(), [&](const StageNode& n) { return n.name == name; });
  };
  while (!waiting.empty()) {
    const auto ready = std::find_if(waiting.begin(), waiting.end(), [&](const StageNode& n) {
      return std::all_of(n.inputs.begin(), n.inputs.end(), [&](const NodeInput& i) { return !i.artifact || placed(i.name); });
    });
    if (ready == waiting.end())
      throw Error(ErrorKind::Dependency,
                  fmt::format("stage '{}' reads from a stage that is not there, or from itself", waiting[0].name),
                  {.where = list.string(), .hint = "build all of vitrine: cmake --build build", .code = "STAGE_BROKEN"});
    graph.nodes.push_back(std::move(*ready));
    waiting.erase(ready);
  }
  return graph;
}

std::optional<PrintedKey> printed_key(std::string_view output) {
  // The JSON object is indented: only its outer braces are alone on a line.
  std::istringstream lines{std::string(output)};
  std::string object;
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line == "{") object.clear(), inside = true;
    if (inside) object += line + "\n";
    if (line == "}") inside = false;
  }
  const auto json = nlohmann::json::parse(object, nullptr, false);
  if (!json.is_object() || !json.contains("key") || !json.contains("terms")) return std::nullopt;
  return PrintedKey{json.at("key"), json.at("terms").get<KeyTerms>()};
}

std::string key_of_run(std::vector<std::string> words) {
  words.push_back("--print-key");
  std::string text;
  const ProcessResult r = run_process({.arguments = words, .on_line = [&](std::string_view line) { text.append(line) += "\n"; }});
  const auto answer = printed_key(text);
  return r.ok() && answer ? answer->key : "";
}

}  // namespace vitrine
