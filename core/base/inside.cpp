#include "core/base/inside.h"

#include <algorithm>

namespace vitrine {

bool stays_below(const std::filesystem::path& name) {
  return !name.empty() && !name.is_absolute() && name.native().find('\0') == std::string::npos &&
         std::none_of(name.begin(), name.end(), [](const std::filesystem::path& part) { return part == ".."; });
}

}  // namespace vitrine
