// ASCII letters in lower case; all other bytes, those of UTF-8 among them, stay as they are.
#pragma once

#include <string>
#include <string_view>

namespace vitrine {

inline std::string lowered(std::string_view text) {
  std::string low(text);
  for (char& c : low)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return low;
}

}  // namespace vitrine
