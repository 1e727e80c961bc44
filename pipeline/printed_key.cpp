#include "pipeline/printed_key.h"

#include <sstream>

#include "core/foundation/base/json.h"
#include "core/foundation/base/process.h"

namespace vitrine {

std::optional<PrintedKey> printed_key(std::string_view output) {
  // The JSON object is indented: only its outer braces are alone on a line.
  std::istringstream lines{std::string(output)};
  std::string object;
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line == "{") object.clear(), inside = true;
    if (inside) object += line + "\n";
    if (line == "}") inside = false;
  }
  const auto json = nlohmann::json::parse(object, nullptr, false);
  if (!json.is_object() || !json.contains("key") || !json.contains("terms")) return std::nullopt;
  return PrintedKey{json.at("key"), json.at("terms").get<KeyTerms>()};
}

std::string key_of_run(std::vector<std::string> words) {
  words.push_back("--print-key");
  std::string text;
  const ProcessResult r = run_process({.arguments = words, .on_line = [&](std::string_view line) { text.append(line) += "\n"; }});
  const auto answer = printed_key(text);
  return r.ok() && answer ? answer->key : "";
}

}  // namespace vitrine
