#include "core/config/length.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace vitrine {

std::optional<Length> parse_length(std::string_view text) {
  double value = 0;
  const auto [next, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc()) return std::nullopt;
  std::string_view unit = text.substr(size_t(next - text.data()));
  unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
  const double factor = unit.empty() || unit == "m" ? 1 : unit == "cm" ? 0.01 : unit == "mm" ? 0.001 : 0;
  const Length length{value * factor, !unit.empty()};
  if (!(length.metres > 0) || !std::isfinite(length.metres)) return std::nullopt;
  return length;
}

}  // namespace vitrine
