// Small files of the user's (marks, lamps), read value by value: every complaint points at its line, and all are shown at once.
//
//   YamlReader in(read_yaml(path));
//   in.only_keys(node, {"position", "intensity"});
//   const auto p = in.numbers(*node.find("position"), 3, "[x, y, z]");     // nullopt: complained
//   in.finish("core/scene/light/lighting.h shows the format");                   // throws what was collected
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
  void complain(const std::string& message);  // about the file as a whole
  // A map without other keys, and each of them once.
  void only_keys(const YamlNode& map, const std::vector<std::string>& keys);
  std::optional<double> number(const YamlNode& node);  // finite
  std::optional<std::vector<double>> numbers(const YamlNode& node, size_t count, const std::string& what);
  // Throws Error{Usage} with all complaints, if there are any.
  void finish(const std::string& hint) const { errors_.throw_if_any(hint); }

 private:
  YamlFile file_;
  ConfigErrors errors_;
};

}  // namespace vitrine
