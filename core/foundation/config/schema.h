// An OptionTable as JSON and back: what `--describe` of a stage prints, and how the pipeline, which is linked to no stage, gets
// a table of its own to parse and check values with.
#pragma once

#include <deque>
#include <string>
#include <string_view>
#include <variant>

#include "core/foundation/config/describe.h"

namespace vitrine {

// {"options":[{path,type,doc,default,value,low?,high?,choices?,affects_result}],"groups":[{path,doc}]}
std::string options_to_json(const OptionTable& table);

// Owns the values that its table points at. Not copyable: the table would point into the original.
class OwnedOptions {
 public:
  OwnedOptions() = default;
  OwnedOptions(const OwnedOptions&) = delete;
  OwnedOptions& operator=(const OwnedOptions&) = delete;

  OptionTable table;
  // Adds every option of the JSON with `prefix` before its path; values start at the defaults.
  void add_json(std::string_view json, std::string_view prefix);
  // Adds one option with its default.
  Option& add(std::string path, std::string_view type, std::string_view default_text, std::string doc);

 private:
  using Value = std::variant<bool, int, double, std::string, std::vector<double>, std::vector<std::string>>;
  std::deque<Value> values_;  // a deque, because its elements stay where they are
};

}  // namespace vitrine
