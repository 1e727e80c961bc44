#include "core/foundation/base/inside.h"

#include <algorithm>

namespace vitrine {

bool stays_below(const std::filesystem::path& name) {
  return !name.empty() && !name.is_absolute() && name.native().find('\0') == std::string::npos &&
         std::none_of(name.begin(), name.end(), [](const std::filesystem::path& part) { return part == ".."; });
}

namespace {

std::filesystem::path real_path(const std::filesystem::path& path) {
  std::error_code ec;
  const std::filesystem::path whole = std::filesystem::absolute(path, ec);
  std::filesystem::path real = std::filesystem::weakly_canonical(whole, ec);
  if (ec) real = whole.lexically_normal();
  return real.has_filename() ? real : real.parent_path();  // "a/b/" becomes "a/b"
}

}  // namespace

bool lies_in(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const std::filesystem::path inner = real_path(path), outer = real_path(folder);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

}  // namespace vitrine
