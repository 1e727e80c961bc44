// Texts in UTF-8.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace vitrine {

// Length of the sequence at the beginning of `text`, which is not empty; 0 when there is no well-formed one (The Unicode
// Standard, table 3-7): overlong forms, halves of surrogate pairs and what lies beyond U+10FFFF are none.
size_t utf8_length(std::string_view text);

// ASCII letters in lower case; all other bytes, those of UTF-8 among them, stay as they are.
inline std::string lowered(std::string_view text) {
  std::string low(text);
  for (char& c : low)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return low;
}

}  // namespace vitrine
