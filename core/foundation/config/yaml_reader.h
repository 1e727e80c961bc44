// Reader for small YAML files of the user (annotations, lamps): collects errors with their line and reports them together.
//
//   YamlReader in(read_yaml(path));
//   in.only_keys(node, {"position", "intensity"});
//   const auto p = in.numbers(*node.find("position"), 3, "[x, y, z]");     // nullopt: error recorded
//   in.finish("core/scene/light/lighting.h shows the format");             // throws the collected errors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/yaml.h"

namespace vitrine {

class YamlReader {
 public:
  explicit YamlReader(YamlFile file) : file_(std::move(file)) {}

  const YamlNode& root() const { return file_.root; }
  const std::string& name() const { return file_.name; }
  void complain(const YamlNode& node, const std::string& message);
  void complain(const std::string& message);  // error about the whole file
  // Requires a map with only these keys, each at most once.
  void only_keys(const YamlNode& map, const std::vector<std::string>& keys);
  std::optional<double> number(const YamlNode& node);  // finite
  std::optional<std::vector<double>> numbers(const YamlNode& node, size_t count, const std::string& what);
  // Throws Error{Usage} with all errors, if any.
  void finish(const std::string& hint) const { errors_.throw_if_any(hint); }

 private:
  YamlFile file_;
  ConfigErrors errors_;
};

}  // namespace vitrine
