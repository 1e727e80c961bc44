// Where paths lie: names that come from files of others must not lead out of the folder they are used in, and results must not
// be written into what they are made from.
#pragma once

#include <filesystem>

namespace vitrine {

// Relative, without "..", and without a zero byte, at which the system would end the name. Whether it exists, and where links
// lead, is not asked.
bool stays_below(const std::filesystem::path& name);

// The path is the folder, or lies below it, wherever links lead. Neither has to exist; relative ones are of the current folder.
bool lies_in(const std::filesystem::path& path, const std::filesystem::path& folder);

}  // namespace vitrine
