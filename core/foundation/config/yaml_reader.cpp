#include "core/foundation/config/yaml_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include <fmt/ranges.h>

#include "core/foundation/config/text.h"

namespace vitrine {

void YamlReader::complain(const YamlNode& node, const std::string& message) {
  errors_.add(file_, node.mark, std::max<size_t>(node.text.size(), 1), message);
}

void YamlReader::complain(const std::string& message) { errors_.add(file_.name, message); }

void YamlReader::only_keys(const YamlNode& map, const std::vector<std::string>& keys) {
  if (map.kind != YamlNode::Kind::Map) return complain(map, fmt::format("expected {}", fmt::join(keys, ", ")));
  for (auto entry = map.entries.begin(); entry != map.entries.end(); ++entry) {
    const YamlNode& key = entry->first;
    const auto same = [&](const auto& other) { return other.first.text == key.text; };
    if (const auto first = std::find_if(map.entries.begin(), entry, same); first != entry) {
      complain(key, fmt::format("'{}' is given twice (first on line {})", key.text, first->first.mark.line));
      continue;
    }
    if (std::find(keys.begin(), keys.end(), key.text) != keys.end()) continue;
    const std::string near = nearest_word(key.text, keys);
    complain(key, fmt::format("unknown key '{}'{}", key.text, near.empty() ? "" : fmt::format("; did you mean '{}'?", near)));
  }
}

std::optional<double> YamlReader::number(const YamlNode& node) {
  double value = 0;
  const char* end = node.text.data() + node.text.size();
  const auto parsed = std::from_chars(node.text.data(), end, value);
  if (node.kind == YamlNode::Kind::Scalar && parsed.ec == std::errc() && parsed.ptr == end && std::isfinite(value)) return value;
  complain(node, fmt::format("expected a number{}", node.text.empty() ? "" : fmt::format(", got \"{}\"", node.text)));
  return std::nullopt;
}

std::optional<std::vector<double>> YamlReader::numbers(const YamlNode& node, size_t count, const std::string& what) {
  if (node.kind != YamlNode::Kind::List || node.items.size() != count) {
    complain(node, fmt::format("expected {}", what));
    return std::nullopt;
  }
  std::vector<double> out;
  for (const YamlNode& item : node.items) {
    const auto value = number(item);
    if (!value) return std::nullopt;
    out.push_back(*value);
  }
  return out;
}

}  // namespace vitrine
