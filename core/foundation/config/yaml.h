// A YAML file as a tree that remembers where every key and value stands, so that each complaint can point at its line.
// A subset on purpose: one document of maps, lists and scalars; anchors, aliases and tags are errors. Parsed by yaml-cpp.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vitrine {

struct SourceMark {
  int line = 1, column = 1;  // both from 1
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

// Syntax errors are Error{Usage} with file:line:col and an excerpt. An empty text gives a Null root.
YamlFile parse_yaml(std::string_view text, std::string name);
YamlFile read_yaml(const std::string& path);
// A file, and called .yaml or .yml, in capitals too.
bool is_yaml_file(const std::filesystem::path& path);

// Complaints are collected, so that one run shows all of them.
class ConfigErrors {
 public:
  // "name:line:col: error: message" plus the line with `length` columns underlined.
  void add(const YamlFile& file, SourceMark mark, size_t length, const std::string& message);
  void add(std::string_view where, const std::string& message);  // "where: error: message"
  bool empty() const { return count_ == 0; }
  // Throws one Error{Usage} with all of them, a count and `hint`.
  void throw_if_any(std::string_view hint) const;

 private:
  std::string text_;
  int count_ = 0;
};

}  // namespace vitrine
