// What a stage program answers to --print-key.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/artifact/manifest.h"

namespace vitrine {

struct PrintedKey {
  std::string key;
  KeyTerms terms;
};
// nullopt: `output` holds no answer. What a library may have printed stands before or behind it.
std::optional<PrintedKey> printed_key(std::string_view output);

// The key of what `words` (program and arguments) would compute; empty when the program fails, which says why when it is run.
std::string key_of_run(std::vector<std::string> words);

}  // namespace vitrine
