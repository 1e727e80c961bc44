#include "core/foundation/artifact/manifest.h"

#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"

namespace vitrine {

using Json = nlohmann::ordered_json;

namespace {

constexpr int kManifestFormat = 1;

// JSON has no infinities and NaN: non-finite metrics are stored as null and read back as NaN.
Json number(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

std::string term_in_words(const std::string& name, const std::string* before, const std::string* now) {
  const size_t dot = name.find('.');
  const std::string kind = name.substr(0, dot), what = dot == std::string::npos ? std::string() : name.substr(dot + 1);
  const std::string shown = kind == "option" ? "option " + what : kind == "tool" ? what : name;
  if (kind == "input") {
    if (before == nullptr) return fmt::format("input {} added", what);
    return fmt::format("input {} {}", what, now == nullptr ? "left out" : "changed");
  }
  if (before == nullptr) return fmt::format("{} is new ({})", shown, *now);
  if (now == nullptr) return fmt::format("{} is gone (was {})", shown, *before);
  return fmt::format("{} {} -> {}", shown, *before, *now);
}

}  // namespace

std::string key_of(const KeyTerms& terms) {
  Hasher hasher;
  for (const auto& [name, value] : terms) hasher.add(name).add(value);
  return hasher.digest().hex();
}

std::string content_digest_of(const std::vector<OutputFile>& outputs) {
  Hasher hasher;
  for (const OutputFile& file : outputs) hasher.add(file.path).add(file.digest);
  return hasher.digest().hex();
}

std::string to_json(const Manifest& m) {
  Json out = {{"format", kManifestFormat},
              {"stage", m.stage},
              {"version", m.version},
              {"tool_version", m.tool_version},
              {"key", m.key},
              {"content_digest", m.content_digest},
              {"summary", m.summary}};
  out["terms"] = Json::object();
  for (const auto& [name, value] : m.terms) out["terms"][name] = value;
  out["options"] = Json::array();
  for (const OptionEcho& o : m.options) out["options"].push_back({{"path", o.path}, {"value", o.value}, {"origin", o.origin}});
  out["metrics"] = Json::object();
  for (const auto& [name, value] : m.metrics) out["metrics"][name] = number(value);
  out["warnings"] = Json::array();
  for (const ManifestWarning& w : m.warnings) out["warnings"].push_back({{"code", w.code}, {"text", w.text}});
  out["outputs"] = Json::array();
  for (const OutputFile& f : m.outputs) out["outputs"].push_back({{"path", f.path}, {"bytes", f.bytes}, {"digest", f.digest}});
  return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Manifest manifest_from_json(std::string_view text, const std::string& where) {
  try {
    const Json in = Json::parse(text);
    Manifest m;
    if (const int format = in.at("format"); format != kManifestFormat)
      throw Error(ErrorKind::Input, fmt::format("the manifest has format {}, this program reads {}", format, kManifestFormat),
                  {.where = where,
                   .hint = "it was written by another version of vitrine: let the stage run again",
                   .code = "BAD_MANIFEST"});
    m.stage = in.at("stage");
    m.version = in.at("version");
    m.tool_version = in.at("tool_version");
    m.key = in.at("key");
    m.content_digest = in.at("content_digest");
    m.summary = in.at("summary");
    for (const auto& [name, value] : in.at("terms").items()) m.terms[name] = value;
    for (const Json& o : in.at("options")) m.options.push_back({o.at("path"), o.at("value"), o.at("origin")});
    for (const auto& [name, value] : in.at("metrics").items()) m.metrics[name] = value.is_null() ? NAN : value.get<double>();
    for (const Json& w : in.at("warnings")) m.warnings.push_back({w.at("code"), w.at("text")});
    for (const Json& f : in.at("outputs")) m.outputs.push_back({f.at("path"), f.at("bytes"), f.at("digest")});
    return m;
  } catch (const Json::exception& e) {
    throw Error(ErrorKind::Input, "a manifest cannot be read",
                {.where = where,
                 .why = e.what(),
                 .hint = "delete the folder it stands in: the stage runs again",
                 .code = "BAD_MANIFEST"});
  }
}

std::vector<std::string> changed_terms(const KeyTerms& before, const KeyTerms& now) {
  std::vector<std::string> words;
  const auto at = [](const KeyTerms& terms, const std::string& name) {
    const auto found = terms.find(name);
    return found == terms.end() ? nullptr : &found->second;
  };
  KeyTerms all = before;
  all.insert(now.begin(), now.end());
  for (const auto& [name, unused] : all) {
    const std::string *b = at(before, name), *n = at(now, name);
    if (b == nullptr || n == nullptr || *b != *n) words.push_back(term_in_words(name, b, n));
  }
  return words;
}

}  // namespace vitrine
