#include "core/camera/json_text.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>

namespace vitrine {

namespace {

constexpr std::string_view kSpace = " \t\r\n";

// Walks over a document that the parser accepted.
class Walker {
 public:
  explicit Walker(std::string_view text) : text_(text) {}

  size_t at() const { return at_; }
  bool next_is(char c) {
    skip_space();
    return at_ < text_.size() && text_[at_] == c;
  }
  bool take(char c) { return next_is(c) && (++at_, true); }
  void skip_space() { at_ = std::min(text_.find_first_not_of(kSpace, at_), text_.size()); }
  // The raw bytes between the quotes.
  std::string_view string() {
    const size_t begin = ++at_;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    const size_t end = std::min(at_, text_.size());
    at_ = std::min(end + 1, text_.size());
    return text_.substr(begin, end - begin);
  }
  void skip_value() {
    size_t depth = 0;
    do {
      skip_space();
      if (at_ >= text_.size()) return;
      const char c = text_[at_];
      if (c == '"')
        string();
      else if (c == '{' || c == '[')
        ++depth, ++at_;
      else if (c == '}' || c == ']')
        --depth, ++at_;
      else if (c == ',' || c == ':')
        ++at_;
      else
        at_ = std::min(text_.find_first_of(" \t\r\n,:]}", at_), text_.size());
    } while (depth > 0);
  }

 private:
  std::string_view text_;
  size_t at_ = 0;
};

bool enter(Walker& walker, std::string_view part) {
  if (walker.take('{')) {
    while (walker.next_is('"')) {
      const bool found = walker.string() == part;
      walker.take(':');
      if (found) return true;
      walker.skip_value();
      walker.take(',');
    }
    return false;
  }
  if (!walker.take('[')) return false;
  size_t index = 0;
  for (char c : part) {
    if (!std::isdigit(static_cast<unsigned char>(c))) return false;
    index = 10 * index + size_t(c - '0');
  }
  for (; index > 0 && !walker.next_is(']'); --index) {
    walker.skip_value();
    if (!walker.take(',')) return false;
  }
  return !walker.next_is(']');
}

bool word_char(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

}  // namespace

TextPlace place_in_text(std::string_view text, size_t byte) {
  byte = std::min(byte, text.size());
  const std::string_view before = text.substr(0, byte);
  const size_t line_start = before.rfind('\n') + 1;  // npos + 1 = 0
  return {1 + size_t(std::count(before.begin(), before.end(), '\n')), byte - line_start + 1};
}

std::optional<size_t> place_of_value(std::string_view text, std::string_view pointer) {
  Walker walker(text);
  walker.skip_space();
  size_t place = walker.at();
  while (!pointer.empty()) {
    pointer.remove_prefix(1);
    const size_t end = std::min(pointer.find('/'), pointer.size());
    if (!enter(walker, pointer.substr(0, end))) break;
    walker.skip_space();
    place = walker.at();
    pointer.remove_prefix(end);
  }
  return place < text.size() ? std::optional(place) : std::nullopt;
}

std::string syntax_mistake(std::string_view text, size_t& byte, const std::string& otherwise) {
  if (text.find_first_not_of(kSpace) == std::string_view::npos) return "the file is empty";
  if (byte >= text.size()) return "the file ends in the middle: it is truncated, or a bracket or quote is not closed";
  const size_t before = byte == 0 ? std::string_view::npos : text.find_last_not_of(kSpace, byte - 1);
  const char here = text[byte], previous = before == std::string_view::npos ? '\0' : text[before];
  if ((here == '}' || here == ']') && previous == ',') {
    byte = before;
    return fmt::format("the comma before '{}' is one too many", here);
  }
  if (here == ',' && previous == ',') return "two commas follow each other";
  if ((here == '/' && byte + 1 < text.size() && (text[byte + 1] == '/' || text[byte + 1] == '*')) || here == '#' ||
      ((here == '/' || here == '*') && previous == '/'))
    return "a comment stands here: JSON has none, remove it";
  if (previous == '\\' && before + 1 == byte) return "a single backslash in a text: write \\\\ or / (paths of Windows)";
  // The word that the parser stopped in.
  size_t begin = byte, end = byte;
  while (begin > 0 && word_char(text[begin - 1])) --begin;
  while (end < text.size() && word_char(text[end])) ++end;
  const std::string_view word = text.substr(begin, end - begin);
  std::string lower(word);
  for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (lower == "nan" || lower == "inf" || lower == "infinity") {
    byte = begin > 0 && (text[begin - 1] == '-' || text[begin - 1] == '+') ? begin - 1 : begin;
    return fmt::format("'{}' is no number in JSON: the program that wrote the file failed there", text.substr(byte, end - byte));
  }
  if (lower == "none" || lower == "true" || lower == "false") {
    byte = begin;
    return fmt::format("'{}' is Python, not JSON: write {}", word, lower == "none" ? "null" : lower);
  }
  if (here == '\'') return "texts stand in double quotes (\") in JSON, not in single ones";
  const bool string = otherwise.find("unexpected string literal") != std::string::npos;  // `byte` is its last quote
  if (string || otherwise.find("unexpected number literal") != std::string::npos || here == '{' || here == '[') {
    if (string) {
      do byte = byte == 0 ? 0 : text.rfind('"', byte - 1);
      while (byte != std::string_view::npos && byte > 0 && text[byte - 1] == '\\');
      byte = std::min(byte, text.size() - 1);
    } else if (here != '{' && here != '[') {
      byte = begin;
    }
    return otherwise.find("expected ':'") != std::string::npos ? "a colon is missing before this place"
                                                               : "a comma is missing before this place";
  }
  if (here == '+') return "a number with '+' in front is none in JSON";
  if (const size_t quote = otherwise.find("last read:"); otherwise.find("ill-formed UTF-8") != std::string::npos)
    return "a text is not UTF-8" + (quote == std::string::npos ? "" : " (" + otherwise.substr(quote, 80) + ")");
  if (static_cast<unsigned char>(here) < 0x20 && kSpace.find(here) == std::string_view::npos)
    return "a byte that is no text stands here";
  if (here == '\n' || here == '\r' || here == '\t') return "a text is not closed in its line, or holds a tab";
  return fmt::format("'{}' is not expected here", word.empty() ? text.substr(byte, 1) : word.substr(0, 40));
}

}  // namespace vitrine
