#include "pipeline/report_page/facts.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/foundation/config/text.h"

namespace vitrine {

namespace {

std::string count_text(double n) {
  std::string digits = fmt::format("{:.0f}", n);
  for (ptrdiff_t at = ptrdiff_t(digits.size()) - 3; at > 0; at -= 3)
    digits.insert(size_t(at), "\u202f");  // narrow no-break space
  return digits;
}

std::optional<std::string> parts_text(const std::vector<std::pair<std::string, double>>& parts) {
  if (parts.size() < 2) return std::nullopt;
  std::string text;
  for (const auto& [name, n] : parts) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count_text(n), name);
  return text;
}

std::optional<std::string> text_at(const std::string& path, const std::string& allowed, const Facts& report) {
  const std::string text = report.text(path);
  const std::vector<std::string> words = split_list(allowed);
  const bool fits = words.empty() ? report.at(path).known() : std::ranges::find(words, text) != words.end();
  return fits ? std::optional(text) : std::nullopt;
}

std::optional<double> largest_at(const std::string& paths, const Facts& report) {
  std::optional<double> largest;
  for (const std::string& path : split_list(paths)) {
    const auto numbers = numbers_at(report, path);
    if (numbers.empty()) return std::nullopt;
    double sum = 0;
    for (const auto& [name, n] : numbers) sum += n;
    largest = std::max(largest.value_or(sum), sum);
  }
  return largest;
}

std::optional<std::string> text_of_place(const std::string& place, const Facts& report) {
  const size_t split = place.find_first_of(":=");
  const std::string path = place.substr(0, split), form = split == std::string::npos ? "" : place.substr(split + 1);
  if (split == std::string::npos || place[split] == '=') return text_at(path, form, report);
  if (form == "parts") return parts_text(numbers_at(report, path));
  const auto value = largest_at(path, report);
  if (!value) return std::nullopt;
  if (form == "n") return count_text(*value);
  if (const size_t comma = form.find(','); comma != std::string::npos)
    return *value == 1 ? form.substr(0, comma) : form.substr(comma + 1);
  return fmt::format("{:.{}f}", *value, form[0] - '0');
}

}  // namespace

std::optional<std::string> fact_text(const std::string& text, const Facts& report) {
  std::string out;
  size_t at = 0;
  for (size_t open; (open = text.find('{', at)) != std::string::npos;) {
    const size_t close = text.find('}', open);
    if (close == std::string::npos) break;
    const auto value = text_of_place(text.substr(open + 1, close - open - 1), report);
    if (!value) return std::nullopt;
    out += text.substr(at, open - at) + *value;
    at = close + 1;
  }
  return out + text.substr(at);
}

std::vector<std::pair<std::string, double>> numbers_at(const Facts& report, std::string_view path, std::string_view only) {
  std::vector<std::pair<std::string, double>> numbers;
  const size_t star = path.find('*');
  const std::string_view member = path.substr(star == std::string_view::npos ? 0 : std::min(star + 2, path.size()));
  const auto add = [&](const std::string& name, const Facts& item) {
    if (only.empty() || item.boolean(only).value_or(false))
      if (const auto number = item.number(member)) numbers.push_back({name, *number});
  };
  if (star == std::string_view::npos) {
    add({}, report);
    return numbers;
  }
  const Facts all = report.at(path.substr(0, std::max<size_t>(star, 1) - 1));
  for (const Facts& item : all.items()) add({}, item);
  for (const std::string& name : all.keys()) add(name, all.member(name));
  return numbers;
}

}  // namespace vitrine
