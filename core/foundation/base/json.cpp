#include "core/foundation/base/json.h"

#include <cstdint>

namespace nlohmann {
VITRINE_JSON_TEMPLATES(, json)
VITRINE_JSON_TEMPLATES(, ordered_json)
}  // namespace nlohmann

namespace vitrine {

std::string readable(const nlohmann::ordered_json& document) {
  const std::string text = document.dump(2);
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') {  // skip strings
      const size_t begin = i++;
      for (; text[i] != '"'; ++i) i += text[i] == '\\';
      out.append(text, begin, i + 1 - begin);
      continue;
    }
    const size_t next = text[i] == '[' ? text.find_first_of("[]{}\"", i + 1) : std::string::npos;
    if (next == std::string::npos || text[next] != ']') {
      out += text[i];
      continue;
    }
    for (; i <= next; ++i)
      if (text[i] != '\n' && text[i] != ' ')
        out += text[i];
      else if (out.back() == ',')
        out += ' ';
    --i;
  }
  return out + "\n";
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t block = 0;
    const size_t n = bytes.size() - i < 3 ? bytes.size() - i : 3;
    for (size_t k = 0; k < 3; ++k) block = block << 8 | (k < n ? static_cast<uint8_t>(bytes[i + k]) : 0u);
    for (size_t k = 0; k < 4; ++k) out += k <= n ? kLetters[block >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

}  // namespace vitrine
