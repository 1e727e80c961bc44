#include "core/foundation/config/apply.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "core/foundation/config/text.h"

namespace vitrine {

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
