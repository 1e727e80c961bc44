// Option declaration: a struct member with an initialiser, and one line in the struct's `describe`:
//
//   void describe(Describer& d, MeshConfig& c) {
//     d.option("voxel_size_rel", c.voxel_size_rel, "Edge of a TSDF voxel, relative to the scene radius.").range(1e-4, 0.1);
//     d.option("threads", c.threads, "Threads; 0 = all.").range(0, 1024).affects_output(false);
//     d.choice("backend", c.backend, {"cpu", "reference"}, "Renderer.");  // an enum class; words in the order of its values
//     d.group("fusion", c.fusion, "How depth maps are fused.");          // nested struct with its own describe
//   }
//
// These lines define the strict YAML reader, the command line, --help, --describe (JSON), the canonical text of the cache key,
// the copy in the manifest, the reference YAML and the generic tests.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace vitrine {

// Member of an enum class with values 0, 1, ... in the order of the option's words.
struct ChoiceTarget {
  void* value;
  size_t (*get)(const void*);
  void (*set)(void*, size_t);
};
using OptionTarget =
    std::variant<bool*, int*, float*, double*, std::string*, ChoiceTarget, std::vector<double>*, std::vector<std::string>*>;

struct Option {
  std::string path;                  // "fusion.weight_cap", without the stage name
  std::string doc;                   // one sentence
  OptionTarget target;               // member of the described config struct
  std::string default_text;          // canonical text of the value at describe time
  std::optional<double> low, high;   // inclusive range of numbers
  std::vector<std::string> choices;  // allowed words of a string option
  bool affects_result = true;        // false: not in the cache key (threads, log level, preview period)
  bool names_file = false;           // the cache key holds the digest of the file, not its path
  std::string origin = "default";    // "default", "preset preview", "vitrine.yaml:14:3", "--set"

  std::string type() const;  // "bool", "int", "float", "string", "float list", "string list"
  std::string text() const;  // canonical text of the current value: shortest round-trip numbers
  std::string rule() const;  // "an integer >= 1", "one of cpu, reference"
  // Parses and validates. Returns nothing on success (sets value and origin), otherwise the violated rule: `must be an integer
  // >= 1, got "12k"`; the value is unchanged. List syntax: "[a, b]" or "a,b".
  std::optional<std::string> try_assign(std::string_view text, std::string_view new_origin);
  std::optional<std::string> try_assign_list(const std::vector<std::string>& items, std::string_view new_origin);
  // Same, but throws Error{Usage} with option, value and rule. `where` is file:line:col or "--set".
  void assign(std::string_view text, std::string_view where);
  void assign_list(const std::vector<std::string>& items, std::string_view where);
};

class OptionRef {
 public:
  explicit OptionRef(Option& o) : option_(&o) {}
  OptionRef& range(double low, double high) {
    option_->low = low;
    option_->high = high;
    return *this;
  }
  OptionRef& choices(std::vector<std::string> words) {
    option_->choices = std::move(words);
    return *this;
  }
  OptionRef& affects_output(bool yes) {
    option_->affects_result = yes;
    return *this;
  }
  OptionRef& file() {
    option_->names_file = true;
    return *this;
  }

 private:
  Option* option_;
};

struct OptionGroup {
  std::string path, doc;
};

// All options of one config object. Valid while the object exists and does not move.
class OptionTable {
 public:
  std::vector<Option> options;  // in declaration order
  std::vector<OptionGroup> groups;

  Option* find(std::string_view path);
  const Option* find(std::string_view path) const;
  bool is_group(std::string_view path) const;  // true if options exist below the path
  // Nearest path or group by edit distance, for "did you mean"; only the first word if nothing else is near; empty if nothing
  // is near.
  std::string nearest(std::string_view path) const;
  // "path = value" lines sorted by path, only options that affect the result. Used for the cache key.
  std::string canonical_text() const;
};

class Describer {
 public:
  explicit Describer(OptionTable& table, std::string prefix = {}) : table_(table), prefix_(std::move(prefix)) {}
  OptionRef option(std::string_view name, bool& v, std::string_view doc) { return add(name, &v, doc); }
  OptionRef option(std::string_view name, int& v, std::string_view doc) { return add(name, &v, doc); }
  OptionRef option(std::string_view name, float& v, std::string_view doc) { return add(name, &v, doc); }
  OptionRef option(std::string_view name, double& v, std::string_view doc) { return add(name, &v, doc); }
  OptionRef option(std::string_view name, std::string& v, std::string_view doc) { return add(name, &v, doc); }
  OptionRef option(std::string_view name, std::vector<double>& v, std::string_view doc) { return add(name, &v, doc); }
  OptionRef option(std::string_view name, std::vector<std::string>& v, std::string_view doc) { return add(name, &v, doc); }
  template <class Enum>
  OptionRef choice(std::string_view name, Enum& v, std::vector<std::string> words, std::string_view doc) {
    const ChoiceTarget target{&v, [](const void* p) { return static_cast<size_t>(*static_cast<const Enum*>(p)); },
                              [](void* p, size_t i) { *static_cast<Enum*>(p) = static_cast<Enum>(i); }};
    return add(name, target, doc, std::move(words));
  }
  // Words from an array next to the enum, where files and messages use them too.
  template <class Enum, size_t N>
  OptionRef choice(std::string_view name, Enum& v, const std::array<std::string_view, N>& words, std::string_view doc) {
    return choice(name, v, std::vector<std::string>(words.begin(), words.end()), doc);
  }
  template <class Config>
  void group(std::string_view name, Config& config, std::string_view doc) {
    table_.groups.push_back({joined(name), std::string(doc)});
    Describer inner(table_, joined(name));
    describe(inner, config);  // found by argument-dependent lookup
  }

 private:
  std::string joined(std::string_view name) const {
    return prefix_.empty() ? std::string(name) : prefix_ + "." + std::string(name);
  }
  OptionRef add(std::string_view name, OptionTarget target, std::string_view doc, std::vector<std::string> choices = {});
  OptionTable& table_;
  std::string prefix_;
};

template <class Config>
OptionTable options_of(Config& config) {
  OptionTable table;
  Describer d(table);
  describe(d, config);
  return table;
}

}  // namespace vitrine
