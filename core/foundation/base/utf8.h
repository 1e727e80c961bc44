// UTF-8 helpers.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace vitrine {

// Length of the first sequence of non-empty `text`; 0 if it is not well-formed (The Unicode Standard, table 3-7): overlong
// forms, surrogate halves, code points above U+10FFFF.
size_t utf8_length(std::string_view text);

// Lower case for ASCII letters; all other bytes are unchanged.
inline std::string lowered(std::string_view text) {
  std::string low(text);
  for (char& c : low)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return low;
}

}  // namespace vitrine
