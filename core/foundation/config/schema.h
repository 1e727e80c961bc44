// Text forms of an OptionTable: JSON, --help and YAML out; JSON, YAML and `path=value` in.
//
// JSON is the output of a stage's `--describe`. The pipeline does not link the stages; it builds its own
// table from this JSON to parse and validate values.
#pragma once

#include <deque>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/foundation/config/describe.h"
#include "core/foundation/config/yaml.h"

namespace vitrine {

// {"options":[{path,type,doc,default,value,low?,high?,choices?,affects_result}],"groups":[{path,doc}]}
std::string options_to_json(const OptionTable& table);

// Owns the values of its table. Not copyable: the table would point into the original.
class OwnedOptions {
 public:
  OwnedOptions() = default;
  OwnedOptions(const OwnedOptions&) = delete;
  OwnedOptions& operator=(const OwnedOptions&) = delete;

  OptionTable table;
  // Adds every option of the JSON with `prefix` before its path; values are the defaults.
  void add_json(std::string_view json, std::string_view prefix);
  // Adds one option with its default.
  Option& add(std::string path, std::string_view type, std::string_view default_text, std::string doc);

 private:
  using Value = std::variant<bool, int, double, std::string, std::vector<double>, std::vector<std::string>>;
  std::deque<Value> values_;  // a deque keeps element addresses stable
};

// Text output of an OptionTable: the option section of --help, and YAML files (documented reference, or resolved values with
// their origins).

// At least two lines per option, 80 columns: path, type and range, default, description.
std::string help_text(const OptionTable& table);

struct YamlTextDesc {
  bool documentation = false;  // description, rule and default as comments above each value
  bool origins = false;        // origin as a comment after each value
  int indent = 0;              // indentation of the outermost keys, in spaces
};
// All values as block YAML; round-trips exactly.
std::string yaml_text(const OptionTable& table, const YamlTextDesc& desc = {});

// Assigns values to an OptionTable from a YAML map or from `path=value` strings. Strict: unknown keys, duplicates, wrong types
// and out-of-range values are errors with their place.
struct ApplyDesc {
  std::string prefix = {};  // keys are relative to this path ("mesh" for stages/mesh.yaml)
  std::string shown = {};   // prefix of paths in messages ("mesh" for the table of a single stage)
  std::string origin = {};  // prefix of file:line:col in Option::origin ("preset preview")
};

// `map`: node whose keys are options (file.root, or a section of it). A Null node has no effect.
void apply_yaml(const YamlFile& file, const YamlNode& map, OptionTable& table, const ApplyDesc& desc, ConfigErrors& errors);
// One `--set path=value`; '-' in the path is read as '_'. `where` is "--set" or "VITRINE_SET".
void apply_set(std::string_view assignment, OptionTable& table, std::string_view where, ConfigErrors& errors);

}  // namespace vitrine
