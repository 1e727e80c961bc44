#include "pipeline/settings.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <optional>
#include <sstream>

#include "core/foundation/base/error.h"
#include "core/foundation/base/graphics_card.h"
#include "core/foundation/base/log.h"
#include "core/foundation/config/schema.h"
#include "core/foundation/config/text.h"

namespace vitrine {

namespace {

constexpr const char* kDefaultPreset = "standard";

bool is_there(const fs::path& path) {
  std::error_code ec;
  return fs::exists(path, ec);
}

std::optional<fs::path> user_config() {
  const char *xdg = std::getenv("XDG_CONFIG_HOME"), *home = std::getenv("HOME");
  fs::path folder;
  if (xdg != nullptr && *xdg != 0)
    folder = xdg;
  else if (home != nullptr && *home != 0)
    folder = fs::path(home) / ".config";
  else
    return std::nullopt;
  const fs::path file = folder / "vitrine/config.yaml";
  return is_there(file) ? std::optional<fs::path>(file) : std::nullopt;
}

std::vector<std::string> environment_sets() {
  std::vector<std::string> words;
  const char* all = std::getenv("VITRINE_SET");
  std::string text = all == nullptr ? "" : all;
  std::replace(text.begin(), text.end(), '\n', ';');
  std::istringstream in(text);
  for (std::string word; std::getline(in, word, ';');) {
    const size_t first = word.find_first_not_of(' ');
    if (first != std::string::npos) words.push_back(word.substr(first, word.find_last_not_of(' ') - first + 1));
  }
  return words;
}

}  // namespace

fs::path config_folder() {
  const char* chosen = std::getenv("VITRINE_CONFIG_DIR");
  if (chosen != nullptr && *chosen != 0) return chosen;
  // Next to the build folder, installed, or (build folder elsewhere) in the source tree.
  const fs::path next_to_program = own_folder() / "../../configs", installed = own_folder() / "../../share/vitrine/configs",
                 sources = VITRINE_SOURCE_CONFIGS;
  for (const fs::path& folder : {next_to_program, installed, sources})
    if (is_there(folder / "pipelines")) return folder.lexically_normal();
  throw Error(ErrorKind::Dependency, "the presets are missing",
              {.where = (own_folder() / "../../configs").lexically_normal().string(),
               .hint = "set VITRINE_CONFIG_DIR to the folder 'configs' of vitrine",
               .code = "NO_CONFIGS"});
}

std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const auto& e : fs::directory_iterator(config_folder() / "pipelines"))
    if (e.path().extension() == ".yaml") names.push_back(e.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

Settings::Settings(const Graph& graph) {
  options.add("version", "int", "1", "Version of the settings' format.").low = 1;
  options.table.options.back().high = 1;
  options.add("preset", "string", kDefaultPreset, "Quality: a file of configs/pipelines.").choices = preset_names();
  options.table.groups.push_back({"input", "What the user gives. Relative paths start at the file they stand in."});
  for (const NodeInput& input : graph.outside_inputs())
    options.add("input." + input.name, "string", "",
                input.doc + (input.optional ? " \"none\": leave it out even if it is found." : ""));
  options.table.groups.push_back({"limits",
                                  "What the machine may give. Results do not depend on it, except that little memory can mean "
                                  "fewer surfels, and a GPU other roundings."});
  options.add("limits.threads", "int", "0", "Threads; 0 = all.").low = 0;
  options.add("limits.memory", "string", "", "Memory to stay below: 4GiB, 80%; empty = no limit.");
  options
      .add("limits.device", "string", "cpu",
           "What computes pictures in training and evaluation: cpu, cuda, or auto: a GPU if usable.")
      .choices = {kDeviceWords.begin(), kDeviceWords.end()};
  for (const StageNode& node : graph.nodes) {
    options.table.groups.push_back({node.name, node.summary});
    options.add_json(node.description, node.name);
  }
}

std::vector<std::string> Settings::input_texts() const {
  std::vector<std::string> texts;
  for (const Option& o : options.table.options)
    texts.push_back(o.path.starts_with("input.") ? o.origin + "|" + o.text() : std::string());
  return texts;
}

void Settings::anchor_paths(const std::vector<std::string>& before, const fs::path& base) {
  for (size_t i = 0; i < before.size(); ++i) {
    Option& o = options.table.options[i];
    if (!o.path.starts_with("input.") || o.origin + "|" + o.text() == before[i]) continue;
    const std::string value = o.text();
    if (value.empty() || value == "none") continue;
    const std::string origin = o.origin;
    o.assign(fs::absolute(base / value).lexically_normal().string(), origin);
  }
}

void Settings::apply_file(const fs::path& path, const std::string& shown, const std::string& prefix, const std::string& origin,
                          ConfigErrors& errors) {
  YamlFile file = read_yaml(path.string());
  file.name = shown;
  const std::vector<std::string> before = input_texts();
  apply_yaml(file, file.root, options.table, {.prefix = prefix, .origin = origin}, errors);
  anchor_paths(before, path.parent_path());
}

bool Settings::apply_preset(const std::string& name, const std::string& where, ConfigErrors& errors) {
  Option& preset = *options.table.find("preset");
  if (const auto broken = preset.try_assign(name, where)) {
    errors.add(where, fmt::format("'preset' {}", *broken));
    return false;
  }
  const fs::path file = config_folder() / "pipelines" / (name + ".yaml");
  apply_file(file, file.string(), {}, "preset " + name, errors);
  return true;
}

void Settings::load(const SettingsDesc& desc) {
  std::vector<LayerFile> files;
  if (const auto user = user_config()) files.push_back({*user, {}});
  if (desc.read_project && !desc.project.empty() && is_there(desc.project / "vitrine.yaml"))
    files.push_back({desc.project / "vitrine.yaml", {}});
  if (!desc.project.empty() && is_there(desc.project / "stages")) {
    std::vector<fs::path> found;
    for (const auto& e : fs::directory_iterator(desc.project / "stages"))
      if (e.path().extension() == ".yaml") found.push_back(e.path());
    std::sort(found.begin(), found.end());
    for (const fs::path& path : found) files.push_back({path, path.stem().string()});
  }
  ConfigErrors errors;
  const size_t first_of_command = files.size();
  for (const std::string& path : desc.configs) files.push_back({path, {}});

  // The preset is the lowest layer, so its name must be known before the files are applied.
  std::string preset = kDefaultPreset, preset_origin = "default";
  bool preset_from_command = false;
  for (size_t i = 0; i < files.size(); ++i) {
    const LayerFile& f = files[i];
    if (!f.prefix.empty()) continue;
    const YamlFile file = read_yaml(f.path.string());
    const YamlNode* node = file.root.find("preset");
    if (node == nullptr || node->kind != YamlNode::Kind::Scalar) continue;
    preset = node->text;
    preset_origin = fmt::format("{}:{}:{}", f.path.string(), node->mark.line, node->mark.column);
    preset_from_command = i >= first_of_command;
  }
  const std::vector<std::string> environment = environment_sets();
  const auto look_for_preset = [&](const std::string& word, const char* where) {
    if (!word.starts_with("preset=")) return;
    preset = word.substr(7);
    preset_origin = where;
    preset_from_command = true;
  };
  for (const std::string& word : environment) look_for_preset(word, "VITRINE_SET");
  for (const FlagValue& flag : desc.flags) look_for_preset(flag.path + "=" + flag.value, flag.origin.c_str());
  for (const std::string& word : desc.sets) look_for_preset(word, "--set");

  const bool preset_known = apply_preset(preset, preset_origin, errors);
  std::vector<std::string> origins;
  const auto remember = [&] {
    origins.clear();
    for (const Option& o : options.table.options) origins.push_back(o.origin);
  };
  remember();
  for (size_t i = 0; i < files.size(); ++i) {
    if (i == first_of_command) remember();
    const bool section_exists =
        files[i].prefix.empty() || std::any_of(options.table.groups.begin(), options.table.groups.end(),
                                               [&](const OptionGroup& g) { return g.path == files[i].prefix; });
    if (!section_exists)
      errors.add(files[i].path.string(), fmt::format("there is no stage '{}'", files[i].prefix));
    else
      apply_file(files[i].path, files[i].path.string(), files[i].prefix, {}, errors);
  }
  if (files.size() == first_of_command) remember();
  const std::vector<std::string> before = input_texts();
  const auto apply = [&](const std::string& word, const std::string& origin) {
    if (preset_known || !word.starts_with("preset="))
      apply_set(word, options.table, origin, errors);  // report an unknown preset once
  };
  for (const std::string& word : environment) apply(word, "VITRINE_SET");
  for (const FlagValue& flag : desc.flags) apply(flag.path + "=" + flag.value, flag.origin);
  for (const std::string& word : desc.sets) apply(word, "--set");
  anchor_paths(before, fs::current_path());
  errors.throw_if_any("`vitrine config reference` prints all options; `vitrine config show --origin` where each value came from");
  for (size_t i = 0; i < options.table.options.size(); ++i)
    if (options.table.options[i].origin != origins[i]) from_command.insert(options.table.options[i].path);
  if (preset_from_command) from_command.insert("preset");
  find_truth();
}

void Settings::find_truth() {
  Option* truth = options.table.find("input.truth");
  const Option* photos = options.table.find("input.photos");
  if (truth == nullptr || photos == nullptr || !truth->text().empty() || photos->text().empty()) return;
  const fs::path next_to_photos = (fs::path(photos->text()) / "..").lexically_normal() / "truth";
  std::error_code ec;
  if (fs::is_directory(next_to_photos, ec)) truth->assign(next_to_photos.string(), "found next to the photos");
}

std::string Settings::text(std::string_view path) const {
  const Option* o = options.table.find(path);
  VITRINE_CHECK(o != nullptr, "no option '{}'", path);
  return o->text();
}

std::vector<std::string> Settings::stage_arguments(const StageNode& node) const {
  std::vector<std::string> words;
  const std::string stem = node.name + ".";
  for (const Option& o : options.table.options) {
    if (!o.path.starts_with(stem) || o.text() == o.default_text) continue;
    std::string origin = o.origin;
    std::replace(origin.begin(), origin.end(), '|', '/');
    words.insert(words.end(), {"--set-from", fmt::format("{}|{}={}", origin, o.path.substr(stem.size()), o.text())});
  }
  if (const std::string device = text("limits.device"); !node.devices.empty() && device != kDeviceWords[0])
    words.insert(words.end(), {"--device", device});
  return words;
}

}  // namespace vitrine
