// Reads the selector of an edit, or of a part of a composition, from YAML (stages/edit/README.md): 'all', or a map of class,
// object, box, marks, component and except.
#pragma once

#include <span>
#include <string>

#include "core/foundation/config/yaml.h"
#include "core/render/edit/selection.h"

namespace vitrine {

// Photos of marks are looked up in `views`. `words`: description for messages. Mistakes are reported in `in` at their line.
Selector read_selector(YamlReader& in, const YamlNode& node, std::span<const View> views, std::string& words);

}  // namespace vitrine
