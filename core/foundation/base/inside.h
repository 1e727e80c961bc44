// Path containment: names from external files must not leave their folder, and results must not be written into their inputs.
#pragma once

#include <filesystem>

namespace vitrine {

// True for a relative path without ".." and without a zero byte (which would truncate the name). Does not check existence or
// links.
bool stays_below(const std::filesystem::path& name);

// True if the path is the folder or inside it, with links resolved. Neither has to exist; relative paths are relative to the
// current folder.
bool lies_in(const std::filesystem::path& path, const std::filesystem::path& folder);

}  // namespace vitrine
