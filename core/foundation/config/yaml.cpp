#include "core/foundation/config/yaml.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include <fmt/ranges.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/config/text.h"

namespace vitrine {

namespace {

SourceMark mark_of(const YAML::Mark& m) { return {m.line + 1, m.column + 1}; }

// An unclosed bracket is detected at the end; yaml-cpp reports the line after the last one.
SourceMark end_of(const YamlFile& file) {
  for (size_t line = file.lines.size(); line > 0; --line)
    if (const size_t last = file.lines[line - 1].find_last_not_of(" \t"); last != std::string::npos)
      return {static_cast<int>(line), static_cast<int>(last) + 2};
  return {1, 1};
}

struct Unsupported {
  SourceMark mark;
  std::string what;
};

// Builds the tree from parser events. yaml-cpp's Node merges duplicate keys silently on access.
class TreeBuilder : public YAML::EventHandler {
 public:
  YamlNode root;

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& m, YAML::anchor_t anchor) override { leaf(m, YamlNode::Kind::Null, {}, anchor); }
  void OnAlias(const YAML::Mark& m, YAML::anchor_t) override { throw Unsupported{mark_of(m), "aliases (*name)"}; }
  void OnScalar(const YAML::Mark& m, const std::string& tag, YAML::anchor_t anchor, const std::string& value) override {
    if (tag != "?" && tag != "!" && !tag.empty()) throw Unsupported{mark_of(m), "tags (!name)"};
    leaf(m, YamlNode::Kind::Scalar, value, anchor);
  }
  void OnSequenceStart(const YAML::Mark& m, const std::string&, YAML::anchor_t anchor, YAML::EmitterStyle::value) override {
    push(m, YamlNode::Kind::List, anchor);
  }
  void OnSequenceEnd() override { pop(); }
  void OnMapStart(const YAML::Mark& m, const std::string&, YAML::anchor_t anchor, YAML::EmitterStyle::value) override {
    push(m, YamlNode::Kind::Map, anchor);
  }
  void OnMapEnd() override { pop(); }

 private:
  struct Open {
    YamlNode node, key;
    bool has_key = false;
  };

  static void refuse_anchor(const YAML::Mark& m, YAML::anchor_t anchor) {
    if (anchor != 0) throw Unsupported{mark_of(m), "anchors (&name)"};
  }
  void leaf(const YAML::Mark& m, YamlNode::Kind kind, std::string text, YAML::anchor_t anchor) {
    refuse_anchor(m, anchor);
    YamlNode node;
    node.kind = kind;
    node.mark = mark_of(m);
    node.text = std::move(text);
    place(std::move(node));
  }
  void push(const YAML::Mark& m, YamlNode::Kind kind, YAML::anchor_t anchor) {
    refuse_anchor(m, anchor);
    Open open;
    open.node.kind = kind;
    open.node.mark = mark_of(m);
    stack_.push_back(std::move(open));
  }
  void pop() {
    YamlNode done = std::move(stack_.back().node);
    stack_.pop_back();
    place(std::move(done));
  }
  void place(YamlNode node) {
    if (stack_.empty()) {
      root = std::move(node);
      return;
    }
    Open& top = stack_.back();
    if (top.node.kind == YamlNode::Kind::List) {
      top.node.items.push_back(std::move(node));
    } else if (!top.has_key) {
      top.key = std::move(node);
      top.has_key = true;
    } else {
      top.node.entries.emplace_back(std::move(top.key), std::move(node));
      top.has_key = false;
    }
  }

  std::vector<Open> stack_;
};

constexpr size_t kExcerpt = 240;  // columns
constexpr int kMostShown = 100;   // errors; more are only counted

std::string excerpt(const YamlFile& file, SourceMark mark, size_t length) {
  if (mark.line < 1 || mark.line > static_cast<int>(file.lines.size())) return {};
  const std::string& line = file.lines[static_cast<size_t>(mark.line - 1)];
  // For long lines (data files) only the part around the mark.
  const size_t column = std::min(static_cast<size_t>(std::max(mark.column - 1, 0)), line.size());
  const size_t from = column > kExcerpt / 2 && line.size() > kExcerpt ? column - kExcerpt / 2 : 0;
  const std::string shown = line.substr(from, kExcerpt);
  std::string pad;
  for (size_t i = from; i < column; ++i) pad += line[i] == '\t' ? '\t' : ' ';
  length = std::clamp<size_t>(length, 1, kExcerpt);
  return fmt::format("{:>5} | {}\n      | {}^{}\n", mark.line, shown, pad, std::string(length - 1, '~'));
}

// Messages may quote values of any length.
std::string shortened(const std::string& message) {
  constexpr size_t kLongest = 2000;
  return message.size() <= kLongest ? message : message.substr(0, kLongest) + "...";
}

}  // namespace

const YamlNode* YamlNode::find(std::string_view key) const {
  for (const auto& [k, v] : entries)
    if (k.text == key) return &v;
  return nullptr;
}

YamlFile parse_yaml(std::string_view text, std::string name) {
  YamlFile file;
  file.name = std::move(name);
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    file.lines.push_back(std::move(line));
  }
  ConfigErrors errors;
  try {
    std::istringstream in{std::string(text)};
    YAML::Parser parser(in);
    TreeBuilder builder;
    if (parser.HandleNextDocument(builder)) file.root = std::move(builder.root);
    TreeBuilder second;
    if (parser.HandleNextDocument(second) && second.root.kind != YamlNode::Kind::Null)
      errors.add(file, second.root.mark, 1, "a second document is not read: keep one per file");
  } catch (const Unsupported& u) {
    errors.add(file, u.mark, 1, u.what + " are not supported: write the value out");
  } catch (const YAML::Exception& e) {
    const SourceMark mark = mark_of(e.mark), last = end_of(file);
    const bool at_end = e.mark.pos >= static_cast<int>(text.size()) || mark.line > last.line;
    errors.add(file, at_end ? last : mark, 1, "not valid YAML: " + e.msg);
  }
  errors.throw_if_any("indent with spaces, write `key: value`, and put text with special characters in quotes");
  return file;
}

YamlFile read_yaml(const std::string& path) { return parse_yaml(read_text_file(path), path); }

void ConfigErrors::add(const YamlFile& file, SourceMark mark, size_t length, const std::string& message) {
  if (++count_ > kMostShown) return;
  text_ +=
      fmt::format("{}:{}:{}: error: {}\n{}", file.name, mark.line, mark.column, shortened(message), excerpt(file, mark, length));
}

bool is_yaml_file(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return (extension == ".yaml" || extension == ".yml") && std::filesystem::is_regular_file(path);
}

void ConfigErrors::add(std::string_view where, const std::string& message) {
  if (++count_ <= kMostShown) text_ += fmt::format("{}: error: {}\n", where, shortened(message));
}

void ConfigErrors::throw_if_any(std::string_view hint) const {
  if (count_ == 0) return;
  const std::string more = count_ > kMostShown ? fmt::format(", the first {} are shown", kMostShown) : "";
  throw Error(ErrorKind::Usage, fmt::format("{}{} error{}{}", text_, count_, count_ == 1 ? "" : "s", more),
              {.hint = std::string(hint), .code = "BAD_CONFIG"});
}

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
