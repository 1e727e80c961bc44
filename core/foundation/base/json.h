// nlohmann JSON for *.cpp files, with extern templates: lexer, parser and serializer are compiled once, in json.cpp. Otherwise
// each file that uses them takes 1 to 3 seconds more (twice that with sanitizers).
#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

#define VITRINE_JSON_TEMPLATES(prefix, Json)                                                               \
  prefix template class detail::serializer<Json>;                                                          \
  prefix template class detail::lexer<Json, detail::iterator_input_adapter<std::string::const_iterator>>;  \
  prefix template class detail::parser<Json, detail::iterator_input_adapter<std::string::const_iterator>>; \
  prefix template class detail::json_sax_dom_parser<Json>;                                                 \
  prefix template class detail::json_sax_dom_callback_parser<Json>;

namespace nlohmann {
VITRINE_JSON_TEMPLATES(extern, json)
VITRINE_JSON_TEMPLATES(extern, ordered_json)
}  // namespace nlohmann

namespace vitrine {

// Indented by two, newline at the end; arrays of scalars on one line, for manual editing.
std::string readable(const nlohmann::ordered_json& document);

// Message of a nlohmann exception without the prefix "[json.exception.type_error.302]".
inline std::string cause_of(const nlohmann::json::exception& error) {
  std::string_view text = error.what();
  if (const size_t end = text.find("] "); text.starts_with("[json.exception.") && end != std::string_view::npos)
    text.remove_prefix(end + 2);
  return std::string(text);
}

// Base64 encoding (RFC 4648, with padding).
std::string base64(std::string_view bytes);

// Event records of a run (events.jsonl, --log-format json), one JSON object per line, written by stages (stages/reporter.h) and
// the pipeline (pipeline/report.h). configs/events.schema.json lists the fields of each type. A schema change requires a new
// version: configs/events.digests contains the schema digest of every version, checked by a test.
inline constexpr int kEventsVersion = 2;  // version 2 added plan, checkpoint

}  // namespace vitrine
