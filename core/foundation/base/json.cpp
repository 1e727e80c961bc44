#include "core/foundation/base/json.h"

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

}  // namespace vitrine
