#include "core/foundation/config/describe.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <type_traits>

#include "core/foundation/base/error.h"
#include "core/foundation/config/text.h"

namespace vitrine {

namespace {

template <class T>
bool parse_number(std::string_view text, T& out) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

bool parse_finite(std::string_view text, double& out) { return parse_number(text, out) && std::isfinite(out); }

std::optional<bool> parse_bool(std::string_view text) {
  for (std::string_view yes : {"true", "yes", "on"})
    if (text == yes) return true;
  for (std::string_view no : {"false", "no", "off"})
    if (text == no) return false;
  return std::nullopt;
}

bool in_range(const Option& o, double value) { return !(o.low && value < *o.low) && !(o.high && value > *o.high); }

std::string range_words(const Option& o) {
  if (o.low && o.high) return fmt::format(" between {} and {}", *o.low, *o.high);
  if (o.low) return fmt::format(" >= {}", *o.low);
  if (o.high) return fmt::format(" <= {}", *o.high);
  return {};
}

bool allowed_word(const Option& o, std::string_view word) {
  return o.choices.empty() || std::find(o.choices.begin(), o.choices.end(), word) != o.choices.end();
}

}  // namespace

std::string Option::type() const {
  struct Name {
    std::string operator()(bool*) const { return "bool"; }
    std::string operator()(int*) const { return "int"; }
    std::string operator()(float*) const { return "float"; }
    std::string operator()(double*) const { return "float"; }
    std::string operator()(std::string*) const { return "string"; }
    std::string operator()(const ChoiceTarget&) const { return "string"; }
    std::string operator()(std::vector<double>*) const { return "float list"; }
    std::string operator()(std::vector<std::string>*) const { return "string list"; }
  };
  return std::visit(Name{}, target);
}

std::string Option::text() const {
  struct Text {
    const std::vector<std::string>& choices;
    std::string operator()(bool* v) const { return *v ? "true" : "false"; }
    std::string operator()(int* v) const { return fmt::format("{}", *v); }
    std::string operator()(float* v) const { return fmt::format("{}", *v); }
    std::string operator()(double* v) const { return fmt::format("{}", *v); }
    std::string operator()(std::string* v) const { return *v; }
    std::string operator()(const ChoiceTarget& v) const { return choices.at(v.get(v.value)); }
    std::string operator()(std::vector<double>* v) const { return fmt::format("[{}]", fmt::join(*v, ", ")); }
    std::string operator()(std::vector<std::string>* v) const {
      std::vector<std::string> quoted;
      for (const std::string& item : *v) quoted.push_back(quoted_if_needed(item));
      return fmt::format("[{}]", fmt::join(quoted, ", "));
    }
  };
  return std::visit(Text{choices}, target);
}

std::string Option::rule() const {
  const std::string kind = type();
  if (!choices.empty()) return fmt::format("{} {}", kind == "string" ? "one of" : "a list of", fmt::join(choices, ", "));
  if (kind == "bool") return "true or false";
  if (kind == "int") return "an integer" + range_words(*this);
  if (kind == "float") return "a number" + range_words(*this);
  if (kind == "float list") return "a list of numbers" + range_words(*this);
  return kind == "string" ? "a string" : "a list of strings";
}

std::optional<std::string> Option::try_assign(std::string_view text, std::string_view new_origin) {
  if (std::holds_alternative<std::vector<double>*>(target) || std::holds_alternative<std::vector<std::string>*>(target))
    return try_assign_list(split_list(text), new_origin);
  const auto broken = [&] { return fmt::format("must be {}, got \"{}\"", rule(), text); };
  if (auto* p = std::get_if<bool*>(&target)) {
    const std::optional<bool> value = parse_bool(text);
    if (!value) return broken();
    **p = *value;
  } else if (auto* p = std::get_if<int*>(&target)) {
    int value = 0;
    if (!parse_number(text, value) || !in_range(*this, value)) return broken();
    **p = value;
  } else if (auto* p = std::get_if<float*>(&target)) {
    double value = 0;
    if (!parse_finite(text, value) || !in_range(*this, value) || !std::isfinite(static_cast<float>(value))) return broken();
    **p = static_cast<float>(value);
  } else if (auto* p = std::get_if<double*>(&target)) {
    double value = 0;
    if (!parse_finite(text, value) || !in_range(*this, value)) return broken();
    **p = value;
  } else {
    if (!allowed_word(*this, text)) {
      const std::string near = nearest_word(text, choices);
      return broken() + (near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near));
    }
    if (auto* p = std::get_if<ChoiceTarget>(&target))
      p->set(p->value, static_cast<size_t>(std::find(choices.begin(), choices.end(), text) - choices.begin()));
    else
      *std::get<std::string*>(target) = std::string(text);
  }
  origin = std::string(new_origin);
  return std::nullopt;
}

std::optional<std::string> Option::try_assign_list(const std::vector<std::string>& items, std::string_view new_origin) {
  if (auto* p = std::get_if<std::vector<double>*>(&target)) {
    std::vector<double> values;
    for (const std::string& item : items) {
      double value = 0;
      if (!parse_finite(item, value) || !in_range(*this, value)) return fmt::format("must be {}, got \"{}\" in it", rule(), item);
      values.push_back(value);
    }
    **p = std::move(values);
  } else if (auto* p = std::get_if<std::vector<std::string>*>(&target)) {
    for (const std::string& item : items) {
      if (allowed_word(*this, item)) continue;
      const std::string near = nearest_word(item, choices);
      return fmt::format("must be {}, got \"{}\" in it{}", rule(), item,
                         near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near));
    }
    **p = items;
  } else {
    return fmt::format("must be {}, got a list", rule());
  }
  origin = std::string(new_origin);
  return std::nullopt;
}

namespace {
[[noreturn]] void throw_broken(const Option& o, const std::string& broken, std::string_view where) {
  throw Error(
      ErrorKind::Usage, fmt::format("'{}' {}", o.path, broken),
      {.where = std::string(where), .why = o.doc, .hint = "--help lists every option with its range", .code = "BAD_OPTION"});
}
}  // namespace

void Option::assign(std::string_view text, std::string_view where) {
  if (const auto broken = try_assign(text, where)) throw_broken(*this, *broken, where);
}

void Option::assign_list(const std::vector<std::string>& items, std::string_view where) {
  if (const auto broken = try_assign_list(items, where)) throw_broken(*this, *broken, where);
}

Option* OptionTable::find(std::string_view path) {
  for (Option& o : options)
    if (o.path == path) return &o;
  return nullptr;
}
const Option* OptionTable::find(std::string_view path) const { return const_cast<OptionTable*>(this)->find(path); }

bool OptionTable::is_group(std::string_view path) const {
  const std::string stem = std::string(path) + ".";
  return std::any_of(options.begin(), options.end(), [&](const Option& o) { return o.path.starts_with(stem); });
}

std::string OptionTable::nearest(std::string_view path) const {
  std::vector<std::string> words;
  for (const Option& o : options) words.push_back(o.path);
  for (const OptionGroup& g : groups) words.push_back(g.path);
  const std::string near = nearest_word(path, words);
  const size_t dot = path.find('.');
  if (!near.empty() || dot == std::string_view::npos) return near;
  // Typo in the first path part, the rest correct or another typo.
  std::vector<std::string> heads, tails;
  for (const Option& o : options) heads.push_back(o.path.substr(0, o.path.find('.')));
  const std::string head = nearest_word(path.substr(0, dot), heads);
  if (head.empty() || head == path.substr(0, dot)) return {};
  for (const std::string& word : words)
    if (word.starts_with(head + ".")) tails.push_back(word.substr(head.size() + 1));
  const std::string tail = nearest_word(path.substr(dot + 1), tails);
  return tail.empty() ? head : head + "." + tail;
}

std::string OptionTable::canonical_text() const {
  std::vector<std::string> lines;
  for (const Option& o : options)
    if (o.affects_result) lines.push_back(fmt::format("{} = {}\n", o.path, canonical_value(o)));
  std::sort(lines.begin(), lines.end());
  return fmt::format("{}", fmt::join(lines, ""));
}

OptionRef Describer::add(std::string_view name, OptionTarget target, std::string_view doc, std::vector<std::string> choices) {
  Option o;
  o.path = joined(name);
  o.doc = std::string(doc);
  o.target = target;
  o.choices = std::move(choices);
  o.default_text = o.text();
  VITRINE_CHECK(table_.find(o.path) == nullptr, "option '{}' is described twice", o.path);
  table_.options.push_back(std::move(o));
  return OptionRef(table_.options.back());
}

}  // namespace vitrine
