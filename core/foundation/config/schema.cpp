#include "core/foundation/config/schema.h"

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"

namespace vitrine {

using nlohmann::json;

std::string options_to_json(const OptionTable& table) {
  json out = {{"options", json::array()}, {"groups", json::array()}};
  for (const Option& o : table.options) {
    json one = {
        {"path", o.path}, {"type", o.type()}, {"doc", o.doc}, {"default", o.default_text}, {"affects_result", o.affects_result}};
    if (o.low) one["low"] = *o.low;
    if (o.high) one["high"] = *o.high;
    if (!o.choices.empty()) one["choices"] = o.choices;
    out["options"].push_back(std::move(one));
  }
  for (const OptionGroup& g : table.groups) out["groups"].push_back({{"path", g.path}, {"doc", g.doc}});
  return out.dump();
}

Option& OwnedOptions::add(std::string path, std::string_view type, std::string_view default_text, std::string doc) {
  Option o;
  o.path = std::move(path);
  o.doc = std::move(doc);
  const auto own = [&]<class T>(T initial) {
    values_.emplace_back(std::move(initial));
    o.target = &std::get<T>(values_.back());
  };
  if (type == "bool")
    own(false);
  else if (type == "int")
    own(int{0});
  else if (type == "float")
    own(0.0);
  else if (type == "string")
    own(std::string());
  else if (type == "float list")
    own(std::vector<double>());
  else if (type == "string list")
    own(std::vector<std::string>());
  else
    VITRINE_CHECK(false, "option '{}' has the unknown type '{}'", o.path, type);
  o.default_text = std::string(default_text);
  const auto broken = o.try_assign(default_text, "default");
  VITRINE_CHECK(!broken, "default of '{}' {}", o.path, *broken);
  table.options.push_back(std::move(o));
  return table.options.back();
}

void OwnedOptions::add_json(std::string_view text, std::string_view prefix) {
  const json all = json::parse(text);
  const auto below = [&](const std::string& path) { return prefix.empty() ? path : fmt::format("{}.{}", prefix, path); };
  const auto path_of = [&](const json& one) { return below(one.at("path").get<std::string>()); };
  for (const json& one : all.at("options")) {
    Option& o = add(path_of(one), one.at("type").get<std::string>(), one.at("default").get<std::string>(),
                    one.at("doc").get<std::string>());
    if (one.contains("low")) o.low = one["low"].get<double>();
    if (one.contains("high")) o.high = one["high"].get<double>();
    if (one.contains("choices")) o.choices = one["choices"].get<std::vector<std::string>>();
    o.affects_result = one.at("affects_result").get<bool>();
  }
  for (const json& one : all.at("groups")) table.groups.push_back({path_of(one), one.at("doc").get<std::string>()});
}

}  // namespace vitrine
