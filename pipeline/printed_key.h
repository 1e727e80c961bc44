// Parses the output of a stage's --print-key.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/artifact/manifest.h"

namespace vitrine {

struct PrintedKey {
  std::string key;
  KeyTerms terms;
};
// nullopt if `output` contains no key. Other output, from libraries, may precede or follow it.
std::optional<PrintedKey> printed_key(std::string_view output);

// Key of the command `words` (program and arguments); empty if the program fails, which is reported when it is run.
std::string key_of_run(std::vector<std::string> words);

}  // namespace vitrine
