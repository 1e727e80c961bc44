// As much of JSON Schema as configs/events.schema.json uses: type, const, enum, pattern, minimum, items, required, properties,
// additionalProperties, oneOf. A keyword that is not known here is a complaint, so that no rule is skipped unseen.
#pragma once

#include <regex>
#include <set>
#include <string>

#include <fmt/format.h>

#include "core/foundation/base/json.h"

namespace vitrine::test {

inline bool is_of_type(const nlohmann::json& value, const std::string& type) {
  if (type == "integer") return value.is_number_integer();
  if (type == "number") return value.is_number();
  return (type == "string" && value.is_string()) || (type == "boolean" && value.is_boolean()) ||
         (type == "null" && value.is_null()) || (type == "array" && value.is_array()) || (type == "object" && value.is_object());
}

// Empty when `value` obeys `schema`, else the first complaint.
inline std::string schema_complaint(const nlohmann::json& value, const nlohmann::json& schema) {
  static const std::set<std::string> kWords = {
      "$schema", "title",    "description",          "type",  "const",     "enum", "pattern", "minimum",
      "items",   "required", "additionalProperties", "oneOf", "properties"};
  for (const auto& [word, rule] : schema.items())
    if (!kWords.contains(word)) return "the validator does not know '" + word + "'";
  const std::string shown = value.dump().substr(0, 60);
  if (schema.contains("type")) {
    const auto& type = schema["type"];
    bool fits = false;
    for (const auto& t : type.is_array() ? type : nlohmann::json::array({type})) fits |= is_of_type(value, t);
    if (!fits) return shown + " is not of type " + type.dump();
  }
  if (schema.contains("const") && value != schema["const"]) return shown + " is not " + schema["const"].dump();
  if (schema.contains("enum")) {
    const auto& all = schema["enum"];
    if (std::find(all.begin(), all.end(), value) == all.end()) return shown + " is none of " + all.dump();
  }
  if (schema.contains("pattern") && value.is_string() &&
      !std::regex_search(value.get<std::string>(), std::regex(schema["pattern"].get<std::string>())))
    return shown + " does not match " + schema["pattern"].dump();
  if (schema.contains("minimum") && value.is_number() && value < schema["minimum"]) return shown + " is too small";
  if (schema.contains("items") && value.is_array())
    for (const auto& item : value)
      if (const std::string c = schema_complaint(item, schema["items"]); !c.empty()) return c;
  if (value.is_object()) {
    for (const auto& name : schema.value("required", nlohmann::json::array()))
      if (!value.contains(name.get<std::string>())) return "the field " + name.dump() + " is missing";
    const nlohmann::json none = nlohmann::json::object();
    const auto& properties = schema.contains("properties") ? schema["properties"] : none;
    for (const auto& [name, field] : value.items()) {
      std::string c;
      if (properties.contains(name))
        c = schema_complaint(field, properties[name]);
      else if (schema.contains("additionalProperties"))
        c = schema["additionalProperties"] == false ? "no such field" : schema_complaint(field, schema["additionalProperties"]);
      if (!c.empty()) return fmt::format("{}: {}", name, c);
    }
  }
  if (schema.contains("oneOf")) {
    size_t fitting = 0;
    std::string complaints;
    for (const auto& one : schema["oneOf"]) {
      const std::string c = schema_complaint(value, one);
      fitting += c.empty();
      // Of a record of another type nothing else is worth telling.
      if (!c.starts_with("type: ")) complaints += c + "; ";
    }
    if (fitting != 1) return fmt::format("{} forms fit: {}", fitting, complaints.empty() ? "its type is unknown" : complaints);
  }
  return {};
}

}  // namespace vitrine::test
