// YAML parser that stores the line and column of every key and value, for error messages. Supports a subset: one document of
// maps, lists and scalars; anchors, aliases and tags are errors. Based on yaml-cpp.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vitrine {

struct SourceMark {
  int line = 1, column = 1;  // 1-based
};

struct YamlNode {
  enum class Kind { Null, Scalar, List, Map };
  Kind kind = Kind::Null;
  SourceMark mark;
  std::string text;                                    // of a scalar
  std::vector<YamlNode> items;                         // of a list
  std::vector<std::pair<YamlNode, YamlNode>> entries;  // of a map, in file order, duplicates kept

  const YamlNode* find(std::string_view key) const;  // of a map; the first of duplicates
};

struct YamlFile {
  std::string name;  // as shown in messages
  std::vector<std::string> lines;
  YamlNode root;
};

// Throws Error{Usage} with file:line:col and an excerpt for syntax errors. Empty text gives a Null root.
YamlFile parse_yaml(std::string_view text, std::string name);
YamlFile read_yaml(const std::string& path);
// True for existing files with extension .yaml or .yml, case-insensitive.
bool is_yaml_file(const std::filesystem::path& path);

// Collects errors, to report all of them in one run.
class ConfigErrors {
 public:
  // Adds "name:line:col: error: message" and the source line with `length` columns underlined.
  void add(const YamlFile& file, SourceMark mark, size_t length, const std::string& message);
  void add(std::string_view where, const std::string& message);  // "where: error: message"
  bool empty() const { return count_ == 0; }
  // Throws one Error{Usage} with all messages, their number and `hint`.
  void throw_if_any(std::string_view hint) const;

 private:
  std::string text_;
  int count_ = 0;
};

// Reader for small YAML files of the user (annotations, lamps): collects errors with their line and reports them together.
//
//   YamlReader in(read_yaml(path));
//   in.only_keys(node, {"position", "intensity"});
//   const auto p = in.numbers(*node.find("position"), 3, "[x, y, z]");     // nullopt: error recorded
//   in.finish("core/scene/light/lighting.h shows the format");             // throws the collected errors
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
