// Assigns values to an OptionTable from a YAML map or from `path=value` strings. Strict: unknown keys, duplicates, wrong types
// and out-of-range values are errors with their place.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/config/describe.h"
#include "core/foundation/config/yaml.h"

namespace vitrine {

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
