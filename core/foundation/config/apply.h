// Values into an OptionTable: from a YAML map, from `path=value` words. Strict: an unknown key, a duplicate, a value of the wrong
// kind or out of range is an error that names the place; nothing is ignored.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/config/describe.h"
#include "core/foundation/config/yaml.h"

namespace vitrine {

struct ApplyDesc {
  std::string prefix = {};  // options of the table below this path are meant ("mesh" for stages/mesh.yaml)
  std::string shown = {};   // put before paths in messages ("mesh" for the table of the one stage)
  std::string origin = {};  // put before file:line:col in Option::origin ("preset preview")
};

// `map` is the node whose keys are options (file.root, or a section of it). A Null node changes nothing.
void apply_yaml(const YamlFile& file, const YamlNode& map, OptionTable& table, const ApplyDesc& desc, ConfigErrors& errors);
// One `--set path=value`; '-' in the path reads as '_'. `where` is "--set" or "VITRINE_SET".
void apply_set(std::string_view assignment, OptionTable& table, std::string_view where, ConfigErrors& errors);

}  // namespace vitrine
