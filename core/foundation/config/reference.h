// Texts derived from an OptionTable: the option part of --help, and YAML files (the reference with all documentation, or the
// resolved values with their origins).
#pragma once

#include <string>

#include "core/foundation/config/describe.h"

namespace vitrine {

// Two or more lines per option, 80 columns: path, type and range, default, sentence.
std::string help_text(const OptionTable& table);

struct YamlTextDesc {
  bool documentation = false;  // sentence, rule and default as comments above each value
  bool origins = false;        // origin as a comment behind each value
  int indent = 0;              // of the outermost keys, in spaces
};
// All values as block YAML; reading it back gives the same values.
std::string yaml_text(const OptionTable& table, const YamlTextDesc& desc = {});

}  // namespace vitrine
