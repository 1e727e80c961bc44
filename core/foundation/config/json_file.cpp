#include "core/foundation/config/json_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/folder_files.h"
#include "core/foundation/base/json.h"

namespace vitrine {

namespace {

[[noreturn]] void throw_bad_json_at(const fs::path& path, std::string_view text, std::optional<size_t> byte, const char* format,
                                    std::string why) {
  std::string where = path.string();
  if (byte) {
    const TextPlace place = place_in_text(text, *byte);
    where += fmt::format(":{}:{}", place.line, place.column);
  }
  throw_bad_json(where, format, std::move(why));
}

const char* type_in_words(const nlohmann::json& j) {
  if (j.is_null()) return "null";
  if (j.is_string()) return "a text";
  if (j.is_boolean()) return "true or false";
  if (j.is_number()) return "a number";
  return j.is_array() ? "a list" : "an object";
}

}  // namespace

fs::path path_inside(const fs::path& folder, const fs::path& name) {
  if (!stays_below(name)) throw std::invalid_argument("'" + name.string() + "' is not a path inside the folder of this file");
  std::error_code ec;
  const fs::path root = fs::weakly_canonical(folder.empty() ? fs::path(".") : folder, ec);
  const fs::path real = ec ? fs::path() : fs::weakly_canonical(folder / name, ec);
  // Broken or circular links are not followed further.
  if (ec || !stays_below(real.lexically_relative(root)))
    throw std::invalid_argument("'" + name.string() + "' leads out of the folder of this file");
  return folder / name;
}

void throw_bad_json(const fs::path& path, const char* format, std::string why) {
  throw Error(ErrorKind::Input, fmt::format("this is not a usable {}", format),
              {.where = path.string(),
               .why = std::move(why),
               .hint = "correct the file, or run the step that wrote it again",
               .code = "BAD_JSON"});
}

void read_json_file(const fs::path& path, const char* format, const std::function<void(const nlohmann::json&)>& read) {
  const std::string text = read_text_file(path);
  try {
    read(nlohmann::json::parse(text));
  } catch (const nlohmann::json::parse_error& e) {
    size_t byte = std::min(e.byte > 0 ? e.byte - 1 : 0, text.size());
    std::string why = syntax_mistake(text, byte, cause_of(e));
    throw_bad_json_at(path, text, byte, format, std::move(why));
  } catch (const nlohmann::json::exception& e) {
    throw_bad_json(path, format, cause_of(e));
  } catch (const JsonMistake& e) {
    throw_bad_json_at(path, text, place_of_value(text, e.place), format, e.what());
  } catch (const std::invalid_argument& e) {
    throw_bad_json(path, format, e.what());
  }
}

void write_json_file(const fs::path& path, const nlohmann::json& document) {
  // File names are bytes; invalid UTF-8 is replaced instead of an error.
  write_file(path, document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

nlohmann::json json_of(const Vec3d& v) { return {v.x, v.y, v.z}; }

Vec3d vec3_of(const nlohmann::json& j) {
  if (!j.is_array() || j.size() != 3)
    // Structures are not printed: dump() recurses as deep as a malicious file is nested.
    throw std::invalid_argument("expected a list of three numbers, found " +
                                (j.is_structured() ? std::string(j.type_name()) : j.dump().substr(0, 60)));
  const Vec3d v{j[0].get<double>(), j[1].get<double>(), j[2].get<double>()};
  if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) throw std::invalid_argument("a number is not finite");
  return v;
}

bool JsonAt::has(const char* key) const {
  if (!value_->is_object()) return false;
  const auto at = value_->find(key);
  return at != value_->end() && !at->is_null();
}

JsonAt JsonAt::at(const char* key) const {
  if (!value_->is_object()) fail(fmt::format("expected an object with '{}', found {}", key, type_in_words(*value_)));
  if (!has(key)) fail(fmt::format("'{}' is missing", key));
  return JsonAt(*value_->find(key), place_ + "/" + key);
}

JsonAt JsonAt::operator[](size_t index) const {
  if (!value_->is_array() || index >= value_->size()) fail("expected a longer list");
  return JsonAt((*value_)[index], place_ + "/" + std::to_string(index));
}

double JsonAt::number() const {
  if (!value_->is_number()) fail(fmt::format("expected a number, found {}", type_in_words(*value_)));
  const double v = value_->get<double>();
  if (!std::isfinite(v)) fail("the number is not finite");
  return v;
}

std::string JsonAt::text() const {
  if (!value_->is_string()) fail(fmt::format("expected a text, found {}", type_in_words(*value_)));
  return value_->get<std::string>();
}

const JsonAt& JsonAt::list(const char* of) const {
  if (!value_->is_array()) fail(fmt::format("expected {}, found {}", of, type_in_words(*value_)));
  return *this;
}

void JsonAt::fail(const std::string& why) const {
  // "/frames/3/w" -> "frames[3].w"
  std::string shown;
  for (size_t at = 0; at < place_.size();) {
    const size_t end = std::min(place_.find('/', at + 1), place_.size());
    const std::string part = place_.substr(at + 1, end - at - 1);
    const bool index = part.find_first_not_of("0123456789") == std::string::npos;
    shown += index ? "[" + part + "]" : (shown.empty() ? part : "." + part);
    at = end;
  }
  throw JsonMistake(place_, shown.empty() ? why : shown + ": " + why);
}

namespace {

constexpr std::string_view kSpace = " \t\r\n";

// Scans a document that the parser accepted.
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
  // Raw bytes between the quotes.
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
  // Token at which the parser stopped.
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
  const bool string = otherwise.find("unexpected string literal") != std::string::npos;  // `byte` is its closing quote
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
