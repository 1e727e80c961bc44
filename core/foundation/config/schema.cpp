#include "core/foundation/config/schema.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/config/text.h"

namespace vitrine {

using nlohmann::json;

std::string options_to_json(const OptionTable& table) {
  json out = {{"options", json::array()}, {"groups", json::array()}};
  for (const Option& o : table.options) {
    json one = {
        {"path", o.path}, {"type", o.type()}, {"doc", o.doc}, {"default", o.default_text}, {"affects_result", o.affects_result}};
    if (o.low) one["low"] = *o.low;
    if (o.high) one["high"] = *o.high;
    if (!o.choices.empty()) one["choices"] = o.choices;
    out["options"].push_back(std::move(one));
  }
  for (const OptionGroup& g : table.groups) out["groups"].push_back({{"path", g.path}, {"doc", g.doc}});
  return out.dump();
}

Option& OwnedOptions::add(std::string path, std::string_view type, std::string_view default_text, std::string doc) {
  Option o;
  o.path = std::move(path);
  o.doc = std::move(doc);
  const auto own = [&]<class T>(T initial) {
    values_.emplace_back(std::move(initial));
    o.target = &std::get<T>(values_.back());
  };
  if (type == "bool")
    own(false);
  else if (type == "int")
    own(int{0});
  else if (type == "float")
    own(0.0);
  else if (type == "string")
    own(std::string());
  else if (type == "float list")
    own(std::vector<double>());
  else if (type == "string list")
    own(std::vector<std::string>());
  else
    VITRINE_CHECK(false, "option '{}' has the unknown type '{}'", o.path, type);
  o.default_text = std::string(default_text);
  const auto broken = o.try_assign(default_text, "default");
  VITRINE_CHECK(!broken, "default of '{}' {}", o.path, *broken);
  table.options.push_back(std::move(o));
  return table.options.back();
}

void OwnedOptions::add_json(std::string_view text, std::string_view prefix) {
  const json all = json::parse(text);
  const auto below = [&](const std::string& path) { return prefix.empty() ? path : fmt::format("{}.{}", prefix, path); };
  const auto path_of = [&](const json& one) { return below(one.at("path").get<std::string>()); };
  for (const json& one : all.at("options")) {
    Option& o = add(path_of(one), one.at("type").get<std::string>(), one.at("default").get<std::string>(),
                    one.at("doc").get<std::string>());
    if (one.contains("low")) o.low = one["low"].get<double>();
    if (one.contains("high")) o.high = one["high"].get<double>();
    if (one.contains("choices")) o.choices = one["choices"].get<std::vector<std::string>>();
    o.affects_result = one.at("affects_result").get<bool>();
  }
  for (const json& one : all.at("groups")) table.groups.push_back({path_of(one), one.at("doc").get<std::string>()});
}

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
    // 80 columns: the first line is indented by 2, those that follow by 6.
    const std::vector<std::string> lines = wrapped(head, head.size() <= 80 ? 78 : 74);
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

namespace {

std::string joined(std::string_view prefix, std::string_view name) {
  return prefix.empty() ? std::string(name) : fmt::format("{}.{}", prefix, name);
}

std::string unknown_message(const OptionTable& table, const std::string& path, std::string_view shown) {
  const std::string near = table.nearest(path);
  return fmt::format("unknown key '{}'{}", joined(shown, path),
                     near.empty() ? std::string() : fmt::format("; did you mean '{}'?", joined(shown, near)));
}

class Application {
 public:
  Application(const YamlFile& file, OptionTable& table, const ApplyDesc& desc, ConfigErrors& errors)
      : file_(file), table_(table), desc_(desc), errors_(errors) {}

  void map(const YamlNode& node, const std::string& prefix) {
    if (node.kind == YamlNode::Kind::Null) return;
    if (node.kind != YamlNode::Kind::Map) {
      const std::string what = prefix.empty() ? std::string("the file") : fmt::format("'{}'", shown(prefix));
      errors_.add(file_, node.mark, node.text.size(), what + " must be a map of options, `key: value` lines");
      return;
    }
    for (const auto& [key, value] : node.entries) entry(key, value, prefix);
  }

 private:
  std::string shown(std::string_view path) const { return joined(desc_.shown, path); }

  void entry(const YamlNode& key, const YamlNode& value, const std::string& prefix) {
    if (key.kind != YamlNode::Kind::Scalar) {
      errors_.add(file_, key.mark, 1, "a key must be a word");
      return;
    }
    const std::string path = joined(prefix, key.text);
    if (const auto [first, fresh] = seen_.emplace(path, key.mark); !fresh) {
      errors_.add(file_, key.mark, key.text.size(),
                  fmt::format("'{}' is given twice (first on line {})", shown(path), first->second.line));
      return;
    }
    Option* option = table_.find(path);
    if (option == nullptr && !table_.is_group(path)) {
      errors_.add(file_, key.mark, key.text.size(), unknown_message(table_, path, desc_.shown));
      return;
    }
    if (option != nullptr)
      assign(*option, key, value, path);
    else
      map(value, path);
  }

  void assign(Option& option, const YamlNode& key, const YamlNode& value, const std::string& path) {
    const std::string place = fmt::format("{}:{}:{}", file_.name, key.mark.line, key.mark.column);
    const std::string origin = desc_.origin.empty() ? place : fmt::format("{} ({})", desc_.origin, place);
    std::optional<std::string> broken;
    if (value.kind == YamlNode::Kind::Scalar) {
      const bool list = option.type().ends_with(" list");
      broken = list ? option.try_assign_list({value.text}, origin) : option.try_assign(value.text, origin);
    } else if (value.kind == YamlNode::Kind::Null && option.type() == "string") {
      broken = option.try_assign("", origin);
    } else if (value.kind == YamlNode::Kind::List && option.type().ends_with(" list")) {
      list(option, value, path, origin);
      return;
    } else {
      const char* got = value.kind == YamlNode::Kind::Null ? "nothing" : value.kind == YamlNode::Kind::List ? "a list" : "a map";
      broken = fmt::format("must be {}, got {}", option.rule(), got);
    }
    if (!broken) return;
    const bool here = value.kind == YamlNode::Kind::Scalar;
    errors_.add(file_, here ? value.mark : key.mark, here ? value.text.size() : key.text.size(),
                fmt::format("'{}' {}", shown(path), *broken));
  }

  void list(Option& option, const YamlNode& value, const std::string& path, const std::string& origin) {
    std::vector<std::string> items;
    for (const YamlNode& item : value.items) {
      if (item.kind != YamlNode::Kind::Scalar) {
        errors_.add(file_, item.mark, 1, fmt::format("'{}' must be {}, got something nested in it", shown(path), option.rule()));
        return;
      }
      items.push_back(item.text);
    }
    if (const auto broken = option.try_assign_list(items, origin))
      errors_.add(file_, value.mark, 1, fmt::format("'{}' {}", shown(path), *broken));
  }

  const YamlFile& file_;
  OptionTable& table_;
  const ApplyDesc& desc_;
  ConfigErrors& errors_;
  std::map<std::string, SourceMark> seen_;
};

}  // namespace

void apply_yaml(const YamlFile& file, const YamlNode& map, OptionTable& table, const ApplyDesc& desc, ConfigErrors& errors) {
  Application(file, table, desc, errors).map(map, desc.prefix);
}

void apply_set(std::string_view assignment, OptionTable& table, std::string_view where, ConfigErrors& errors) {
  const size_t equals = assignment.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    errors.add(where, fmt::format("expected path=value, got \"{}\"", assignment));
    return;
  }
  std::string path(assignment.substr(0, equals));
  std::replace(path.begin(), path.end(), '-', '_');
  Option* option = table.find(path);
  if (option == nullptr) {
    if (table.is_group(path))
      errors.add(where, fmt::format("'{}' is a group of options: name one of them, as in {}.NAME=VALUE", path, path));
    else
      errors.add(where, unknown_message(table, path, {}));
    return;
  }
  if (const auto broken = option->try_assign(assignment.substr(equals + 1), where))
    errors.add(where, fmt::format("'{}' {}", path, *broken));
}

}  // namespace vitrine
