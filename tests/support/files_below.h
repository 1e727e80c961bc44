// Contents of all files of a folder, for comparisons byte for byte.
#pragma once

#include <map>
#include <string>

#include "core/foundation/base/file.h"

namespace vitrine::test {

// path relative to `folder` -> bytes
inline std::map<std::string, std::string> files_below(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& e : fs::recursive_directory_iterator(folder))
    if (e.is_regular_file()) files[e.path().lexically_relative(folder).string()] = read_file(e.path());
  return files;
}

}  // namespace vitrine::test
