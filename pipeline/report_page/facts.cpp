#include "pipeline/report_page/facts.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"

namespace vitrine {

using Json = nlohmann::ordered_json;

namespace {

constexpr uintmax_t kLargestFile = uintmax_t(1) << 28;

const Json* json_of(const void* node) { return static_cast<const Json*>(node); }

}  // namespace

Facts Facts::of_text(const std::string& text) {
  auto document = std::make_shared<Json>(Json::parse(text, nullptr, false));
  if (document->is_discarded()) return {};
  const void* root = document.get();
  return {std::move(document), root};
}

Facts Facts::of_file(const fs::path& path) { return of_text(text_of_file(path)); }

Facts Facts::member(std::string_view name) const {
  const Json* j = json_of(node_);
  if (j == nullptr || !j->is_object()) return {};
  const auto found = j->find(std::string(name));
  return found == j->end() ? Facts() : Facts(document_, &*found);
}

Facts Facts::at(std::string_view path) const {
  Facts here = *this;
  while (!path.empty()) {
    const size_t dot = path.find('.');
    here = here.member(path.substr(0, dot));
    path = dot == std::string_view::npos ? std::string_view() : path.substr(dot + 1);
  }
  return here;
}

std::vector<Facts> Facts::items() const {
  std::vector<Facts> all;
  const Json* j = json_of(node_);
  if (j != nullptr && j->is_array())
    for (const Json& item : *j) all.push_back({document_, &item});
  return all;
}

std::vector<std::string> Facts::keys() const {
  std::vector<std::string> all;
  const Json* j = json_of(node_);
  if (j != nullptr && j->is_object())
    for (const auto& [key, value] : j->items()) all.push_back(key);
  return all;
}

std::optional<double> Facts::number(std::string_view path) const {
  const Json* j = json_of(at(path).node_);
  if (j == nullptr || !j->is_number()) return std::nullopt;
  const double value = j->get<double>();
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<double> Facts::amount(std::string_view path) const {
  constexpr double kMost = 1e15;
  const auto value = number(path);
  return value && *value >= 0 && *value <= kMost ? value : std::nullopt;
}

std::optional<bool> Facts::boolean(std::string_view path) const {
  const Json* j = json_of(at(path).node_);
  return j != nullptr && j->is_boolean() ? std::optional(j->get<bool>()) : std::nullopt;
}

std::string Facts::text(std::string_view path) const {
  const Json* j = json_of(at(path).node_);
  return j != nullptr && j->is_string() ? j->get<std::string>() : std::string();
}

std::string text_of_file(const fs::path& path) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec) || fs::file_size(path, ec) > kLargestFile) return {};
  try {
    return read_file(path);
  } catch (const Error&) {
    return {};
  }
}

std::vector<std::map<std::string, std::string>> rows_of_csv(const std::string& text) {
  std::vector<std::vector<std::string>> lines(1, {""});
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (quoted) {
      if (c != '"')
        lines.back().back() += c;
      else if (i + 1 < text.size() && text[i + 1] == '"')
        lines.back().back() += text[++i];
      else
        quoted = false;
    } else if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      lines.back().emplace_back();
    } else if (c == '\n') {
      lines.push_back({""});
    } else if (c != '\r') {
      lines.back().back() += c;
    }
  }
  std::vector<std::map<std::string, std::string>> rows;
  for (size_t l = 1; l < lines.size(); ++l) {
    if (lines[l].size() < 2) continue;
    std::map<std::string, std::string>& row = rows.emplace_back();
    for (size_t i = 0; i < std::min(lines[l].size(), lines[0].size()); ++i) row[lines[0][i]] = lines[l][i];
  }
  return rows;
}

std::optional<double> number_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || text.empty() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace vitrine
