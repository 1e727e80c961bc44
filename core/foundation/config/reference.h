// Text output of an OptionTable: the option section of --help, and YAML files (documented reference, or resolved values with
// their origins).
#pragma once

#include <string>

#include "core/foundation/config/describe.h"

namespace vitrine {

// At least two lines per option, 80 columns: path, type and range, default, description.
std::string help_text(const OptionTable& table);

struct YamlTextDesc {
  bool documentation = false;  // description, rule and default as comments above each value
  bool origins = false;        // origin as a comment after each value
  int indent = 0;              // indentation of the outermost keys, in spaces
};
// All values as block YAML; round-trips exactly.
std::string yaml_text(const OptionTable& table, const YamlTextDesc& desc = {});

}  // namespace vitrine
