// JSON file input and output with errors that contain the file name. For *.cpp files only (keeps nlohmann out of public
// headers).
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/foundation/base/json.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

// Parses `path` and calls `read` with the document. Syntax errors, missing keys and wrong types throw Error{Input} with file,
// line and column (if known) and cause; `format` describes the expected file.
void read_json_file(const std::filesystem::path& path, const char* format,
                    const std::function<void(const nlohmann::json&)>& read);
// Indented, sorted keys, shortest exact numbers, newline at the end.
void write_json_file(const std::filesystem::path& path, const nlohmann::json& document);
// Returns `name`, given in a file of `folder`, as a path inside that folder: relative, without "..", not through a link that
// leads out. Throws std::invalid_argument; for use inside read_json_file.
std::filesystem::path path_inside(const std::filesystem::path& folder, const std::filesystem::path& name);
[[noreturn]] void throw_bad_json(const std::filesystem::path& path, const char* format, std::string why);

nlohmann::json json_of(const Vec3d& v);
Vec3d vec3_of(const nlohmann::json& j);  // throws nlohmann exceptions; for use inside read_json_file

// Error at a known place of the document; read_json_file adds line and column. For use inside read_json_file.
struct JsonMistake : std::invalid_argument {
  JsonMistake(std::string pointer, const std::string& why) : std::invalid_argument(why), place(std::move(pointer)) {}
  std::string place;  // JSON pointer, "/frames/3/transform_matrix"
};

// JSON value with its path in the document. Missing values and wrong types throw JsonMistake: "frames[3].file_path: expected a
// text, found a number".
class JsonAt {
 public:
  explicit JsonAt(const nlohmann::json& value, std::string place = {}) : value_(&value), place_(std::move(place)) {}

  const nlohmann::json& value() const { return *value_; }
  bool has(const char* key) const;        // key of an object, value not null
  JsonAt at(const char* key) const;       // required key
  JsonAt operator[](size_t index) const;  // list element, range-checked
  size_t size() const { return value_->size(); }
  double number() const;  // finite
  std::string text() const;
  const JsonAt& list(const char* of) const;  // requires a list; `of`: expected content, "a list of frames"
  [[noreturn]] void fail(const std::string& why) const;

 private:
  const nlohmann::json* value_;
  std::string place_;
};

// Positions in the text of a JSON document, and explanations of syntax errors.
struct TextPlace {
  size_t line = 1, column = 1;
};
TextPlace place_in_text(std::string_view text, size_t byte);
// First byte of the value at a JSON pointer ("/frames/3/w"), or of its deepest existing ancestor; nullopt if `text` is not
// well-formed.
std::optional<size_t> place_of_value(std::string_view text, std::string_view pointer);
// Explains the syntax error at `byte`, where the parser stopped: a trailing comma, a comment, NaN, ... `otherwise`: the
// parser's message. May move `byte` to the start of the error.
std::string syntax_mistake(std::string_view text, size_t& byte, const std::string& otherwise);

}  // namespace vitrine
