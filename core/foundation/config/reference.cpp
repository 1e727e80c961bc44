#include "core/foundation/config/reference.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/foundation/config/text.h"

namespace vitrine {

namespace {

std::vector<std::string> parts_of(std::string_view path) {
  std::vector<std::string> parts;
  size_t at = 0;
  for (size_t dot; (dot = path.find('.', at)) != std::string_view::npos; at = dot + 1)
    parts.emplace_back(path.substr(at, dot - at));
  parts.emplace_back(path.substr(at));
  return parts;
}

std::string value_text(const Option& o) { return o.type() == "string" ? quoted_if_needed(o.text()) : o.text(); }

std::string default_text(const Option& o) {
  if (o.type() == "string") return o.default_text.empty() ? "empty" : quoted_if_needed(o.default_text);
  return o.default_text == "[]" ? "empty" : o.default_text;
}

std::string kind_text(const Option& o) {
  if (!o.choices.empty() || o.low || o.high || o.type() == "bool") return o.rule();
  return o.type();
}

const OptionGroup* group_at(const OptionTable& table, std::string_view path) {
  const auto found = std::find_if(table.groups.begin(), table.groups.end(), [&](const OptionGroup& g) { return g.path == path; });
  return found == table.groups.end() ? nullptr : &*found;
}

std::string comment(const std::string& text, size_t indent) {
  std::string out;
  for (const std::string& line : wrapped(text, std::max<size_t>(40, 98 - indent)))
    out += fmt::format("{:{}}# {}\n", "", indent, line);
  return out;
}

}  // namespace

std::string help_text(const OptionTable& table) {
  std::string out;
  for (const Option& o : table.options) {
    std::string head = fmt::format("  {}: {}, default {}", o.path, kind_text(o), default_text(o));
    if (!o.affects_result) head += " (same result)";
    const std::vector<std::string> lines = wrapped(head, 78);
    for (size_t i = 0; i < lines.size(); ++i) out += fmt::format("{}{}\n", i == 0 ? "  " : "      ", lines[i]);
    for (const std::string& line : wrapped(o.doc, 74)) out += fmt::format("      {}\n", line);
  }
  return out;
}

std::string yaml_text(const OptionTable& table, const YamlTextDesc& desc) {
  // Groups the options: a stable sort by first appearance of each enclosing group.
  std::vector<std::string> order;
  const auto rank = [&](const std::string& path) {
    const auto found = std::find(order.begin(), order.end(), path);
    if (found != order.end()) return found - order.begin();
    order.push_back(path);
    return static_cast<std::ptrdiff_t>(order.size()) - 1;
  };
  std::vector<std::pair<std::vector<std::ptrdiff_t>, const Option*>> sorted;
  for (const Option& o : table.options) {
    std::vector<std::ptrdiff_t> key;
    std::string prefix;
    for (const std::string& part : parts_of(o.path)) {
      prefix = prefix.empty() ? part : fmt::format("{}.{}", prefix, part);
      key.push_back(rank(prefix));
    }
    sorted.emplace_back(std::move(key), &o);
  }
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) { return a.first < b.first; });

  std::string out;
  std::vector<std::string> open;  // groups open at the last line
  for (const auto& [key, option] : sorted) {
    const std::vector<std::string> parts = parts_of(option->path);
    size_t shared = 0;
    while (shared < open.size() && shared + 1 < parts.size() && open[shared] == parts[shared]) ++shared;
    open.resize(shared);
    for (size_t i = shared; i + 1 < parts.size(); ++i) {
      open.push_back(parts[i]);
      const size_t indent = static_cast<size_t>(desc.indent) + 2 * i;
      const OptionGroup* group = group_at(table, fmt::format("{}", fmt::join(open, ".")));
      if (desc.documentation && group != nullptr)
        out += fmt::format("{}{}", out.empty() ? "" : "\n", comment(group->doc, indent));
      out += fmt::format("{:{}}{}:\n", "", indent, parts[i]);
    }
    const size_t indent = static_cast<size_t>(desc.indent) + 2 * (parts.size() - 1);
    if (desc.documentation) {
      std::string text = fmt::format("{} [{}; default {}]", option->doc, kind_text(*option), default_text(*option));
      if (!option->affects_result) text += " Does not change the result.";
      out += comment(text, indent);
    }
    std::string line = fmt::format("{:{}}{}: {}", "", indent, parts.back(), value_text(*option));
    if (desc.origins) line += fmt::format("  # {}", option->origin);
    out += fmt::format("{}\n", line);
  }
  return out;
}

}  // namespace vitrine
