// All settings of a run in one table, merged from layers; every value stores its origin:
//   built-in defaults < preset < ~/.config/vitrine/config.yaml < PROJECT/vitrine.yaml < PROJECT/stages/<stage>.yaml
//   < -c FILE (left to right) < $VITRINE_SET < flags and --set
// Paths of the table: preset, input.<name>, limits.<name>, <stage>.<option>.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "core/foundation/config/schema.h"
#include "core/foundation/config/yaml.h"
#include "pipeline/graph.h"

namespace vitrine {

struct FlagValue {
  std::string path, value, origin;  // "input.poses", "poses/", "--poses"
};

struct SettingsDesc {
  fs::path project = {};                  // empty: no project yet
  bool read_project = true;               // false: its vitrine.yaml will be replaced
  std::vector<std::string> configs = {};  // -c
  std::vector<FlagValue> flags = {};      // --preset, --poses, ...
  std::vector<std::string> sets = {};     // --set
};

class Settings {
 public:
  explicit Settings(const Graph& graph);
  // Throws Error{Usage} with the errors of all layers.
  void load(const SettingsDesc& desc);

  OwnedOptions options;
  std::set<std::string> from_command;  // paths given by -c, VITRINE_SET, flags and --set

  std::string text(std::string_view path) const;  // of an existing option
  // `--set-from ORIGIN|option=value` for every option of the stage that differs from its default, and `--device`.
  std::vector<std::string> stage_arguments(const StageNode& node) const;

 private:
  struct LayerFile {
    fs::path path;
    std::string prefix;  // "mesh" for stages/mesh.yaml
  };
  // A folder `truth` next to the photos, unless input.truth is set, even to "none".
  void find_truth();
  // Resolves relative paths of input.* set in this layer against `base`.
  void anchor_paths(const std::vector<std::string>& before, const fs::path& base);
  std::vector<std::string> input_texts() const;
  void apply_file(const fs::path& path, const std::string& shown, const std::string& prefix, const std::string& origin,
                  ConfigErrors& errors);
  // Returns false if the preset does not exist.
  bool apply_preset(const std::string& name, const std::string& where, ConfigErrors& errors);
};

// Folder with pipelines/*.yaml: $VITRINE_CONFIG_DIR, the source tree's configs, or the installed share.
fs::path config_folder();
std::vector<std::string> preset_names();

}  // namespace vitrine
