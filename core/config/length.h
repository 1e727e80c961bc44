// A length as a user writes it: "24cm", "0.24 m", "240mm".
#pragma once

#include <optional>
#include <string_view>

namespace vitrine {

struct Length {
  double metres = 0;
  bool has_unit = false;  // a bare number counts as metres
};

// Nothing when the text is not of that form, or the length is not finite and above zero.
std::optional<Length> parse_length(std::string_view text);

}  // namespace vitrine
