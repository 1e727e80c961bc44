#include "core/foundation/config/cli.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/config/text.h"

namespace vitrine {

void CommandLine::add(std::string_view name, char letter, std::string_view value, std::string_view doc,
                      std::function<void(const std::string&)> set) {
  flags_.push_back({std::string(name), std::string(value), std::string(doc), letter, std::move(set), section_});
}

void CommandLine::flag(std::string_view name, char letter, bool& target, std::string_view doc) {
  add(name, letter, {}, doc, [&target](const std::string&) { target = true; });
}

void CommandLine::value(std::string_view name, char letter, std::string_view value, std::string& target, std::string_view doc) {
  add(name, letter, value, doc, [&target](const std::string& text) { target = text; });
}

void CommandLine::value(std::string_view name, char letter, std::string_view value, int& target, int low, std::string_view doc) {
  const std::string shown(name);
  add(name, letter, value, doc, [this, &target, low, shown](const std::string& text) {
    int parsed = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), parsed);
    if (error != std::errc() || end != text.data() + text.size() || parsed < low)
      usage_error(fmt::format("--{} must be an integer >= {}, got \"{}\"", shown, low, text));
    target = parsed;
  });
}

void CommandLine::values(std::string_view name, char letter, std::string_view value, std::vector<std::string>& target,
                         std::string_view doc) {
  add(name, letter, value, doc, [&target](const std::string& text) { target.push_back(text); });
}

void CommandLine::section(std::string_view title) { section_ = std::string(title); }

const CommandLine::Flag* CommandLine::find(std::string_view name) const {
  for (const Flag& f : flags_)
    if (f.name == name) return &f;
  return nullptr;
}

void CommandLine::usage_error(const std::string& message, const std::string& hint) const {
  throw Error(ErrorKind::Usage, message, {.hint = hint.empty() ? program_ + " --help" : hint, .code = "USAGE"});
}

std::vector<std::string> CommandLine::parse(const std::vector<std::string>& arguments, size_t most) const {
  std::vector<std::string> rest;
  for (size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word == "--") {
      rest.insert(rest.end(), arguments.begin() + static_cast<std::ptrdiff_t>(i) + 1, arguments.end());
      break;
    }
    if (word.size() < 2 || word[0] != '-') {
      rest.push_back(word);
      continue;
    }
    const Flag* found = nullptr;
    std::string attached, shown = word;
    bool has_attached = false;
    if (word.starts_with("--")) {
      const size_t equals = word.find('=');
      std::string name = word.substr(2, equals == std::string::npos ? std::string::npos : equals - 2);
      std::replace(name.begin(), name.end(), '_', '-');
      shown = "--" + name;
      if (equals != std::string::npos) {
        attached = word.substr(equals + 1);
        has_attached = true;
      }
      found = find(name);
      if (found == nullptr) {
        std::vector<std::string> names;
        for (const Flag& f : flags_) names.push_back(f.name);
        const std::string near = nearest_word(name, names);
        usage_error(
            fmt::format("unknown flag {}{}", shown, near.empty() ? std::string() : fmt::format("; did you mean --{}?", near)));
      }
    } else {
      for (const Flag& f : flags_)
        if (f.letter == word[1]) found = &f;
      if (found == nullptr) usage_error(fmt::format("unknown flag {}", word));
      if (word.size() > 2) {
        attached = word.substr(2);
        has_attached = true;
      }
    }
    if (found->value.empty()) {
      if (has_attached) usage_error(fmt::format("{} takes no value", shown));
      found->set({});
    } else if (has_attached) {
      found->set(attached);
    } else if (i + 1 < arguments.size()) {
      found->set(arguments[++i]);
    } else {
      usage_error(fmt::format("{} needs a value: {} {}", shown, shown, found->value));
    }
  }
  if (rest.size() > most) usage_error(fmt::format("unexpected argument \"{}\"", rest[most]));
  return rest;
}

std::string CommandLine::help(std::string_view tail) const {
  constexpr size_t kColumn = 28, kWidth = 79;
  std::string out = fmt::format("usage: {}{}{}\n", program_, usage_.empty() ? "" : " ", usage_);
  for (const std::string& line : wrapped(summary_, kWidth)) out += line + "\n";
  std::string section = "\n";
  for (const Flag& f : flags_) {
    if (f.section != section) {
      out += fmt::format("\n{}\n", f.section.empty() ? "options:" : f.section + ":");
      section = f.section;
    }
    std::string head = f.letter != 0 ? fmt::format("  -{}, --{}", f.letter, f.name) : fmt::format("      --{}", f.name);
    if (!f.value.empty()) head += " " + f.value;
    const std::vector<std::string> lines = wrapped(f.doc, kWidth - kColumn);
    size_t first = 0;
    if (head.size() + 2 <= kColumn && !lines.empty()) {
      out += fmt::format("{:<{}}{}\n", head, kColumn, lines[0]);
      first = 1;
    } else {
      out += head + "\n";
    }
    for (size_t i = first; i < lines.size(); ++i) out += fmt::format("{:{}}{}\n", "", kColumn, lines[i]);
  }
  if (!tail.empty()) out += fmt::format("\n{}", tail);
  return out;
}

size_t parse_bytes(std::string_view text, size_t whole, std::string_view where) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  std::string unit(end, text.data() + text.size());
  std::erase(unit, ' ');
  double factor = 0;
  if (unit.empty() || unit == "B")
    factor = 1;
  else if (unit == "%" && number <= 100)
    factor = static_cast<double>(whole) / 100;
  else if (unit == "K" || unit == "KiB")
    factor = 1024;
  else if (unit == "M" || unit == "MiB")
    factor = 1024.0 * 1024;
  else if (unit == "G" || unit == "GiB")
    factor = 1024.0 * 1024 * 1024;
  else if (unit == "T" || unit == "TiB")
    factor = 1024.0 * 1024 * 1024 * 1024;
  else if (unit == "KB")
    factor = 1e3;
  else if (unit == "MB")
    factor = 1e6;
  else if (unit == "GB")
    factor = 1e9;
  const double bytes = number * factor;
  if (error != std::errc() || factor == 0 || !(bytes >= 1) || bytes > 9e18)
    throw Error(ErrorKind::Usage, fmt::format("a size like 4GiB, 512M or 80% is expected, got \"{}\"", text),
                {.where = std::string(where), .hint = "80% is of this machine's memory", .code = "BAD_SIZE"});
  return static_cast<size_t>(bytes);
}

}  // namespace vitrine
