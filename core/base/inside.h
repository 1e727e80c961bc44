// Names that come from files of others and must not lead out of the folder they are used in.
#pragma once

#include <filesystem>

namespace vitrine {

// Relative, without "..", and without a zero byte, at which the system would end the name. Whether it exists, and where links
// lead, is not asked.
bool stays_below(const std::filesystem::path& name);

}  // namespace vitrine
