// OptionTable to JSON and back: the output of a stage's `--describe`. The pipeline does not link the stages; it builds its own
// table from this JSON to parse and validate values.
#pragma once

#include <deque>
#include <string>
#include <string_view>
#include <variant>

#include "core/foundation/config/describe.h"

namespace vitrine {

// {"options":[{path,type,doc,default,value,low?,high?,choices?,affects_result}],"groups":[{path,doc}]}
std::string options_to_json(const OptionTable& table);

// Owns the values of its table. Not copyable: the table would point into the original.
class OwnedOptions {
 public:
  OwnedOptions() = default;
  OwnedOptions(const OwnedOptions&) = delete;
  OwnedOptions& operator=(const OwnedOptions&) = delete;

  OptionTable table;
  // Adds every option of the JSON with `prefix` before its path; values are the defaults.
  void add_json(std::string_view json, std::string_view prefix);
  // Adds one option with its default.
  Option& add(std::string path, std::string_view type, std::string_view default_text, std::string doc);

 private:
  using Value = std::variant<bool, int, double, std::string, std::vector<double>, std::vector<std::string>>;
  std::deque<Value> values_;  // a deque keeps element addresses stable
};

}  // namespace vitrine
