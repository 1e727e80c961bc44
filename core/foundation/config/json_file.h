// JSON files of this module: parsed and written with errors that name the file. For *.cpp files only (nlohmann stays out of
// public headers).
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

// Parses `path` and hands the document to `read`. Syntax errors, missing keys and wrong types become Error{Input} with the
// file, the line and column where they are known, and the cause; `format` says in words what the file should be.
void read_json_file(const std::filesystem::path& path, const char* format,
                    const std::function<void(const nlohmann::json&)>& read);
// Indented, keys sorted, numbers in their shortest exact form, newline at the end.
void write_json_file(const std::filesystem::path& path, const nlohmann::json& document);
// `name`, given in a file of `folder`, as a path that stays in that folder: relative, without "..", and not through a link that
// leads out. Throws std::invalid_argument, for use inside read_json_file.
std::filesystem::path path_inside(const std::filesystem::path& folder, const std::filesystem::path& name);
[[noreturn]] void throw_bad_json(const std::filesystem::path& path, const char* format, std::string why);

nlohmann::json json_of(const Vec3d& v);
Vec3d vec3_of(const nlohmann::json& j);  // throws nlohmann's exceptions, for use inside read_json_file

// A mistake at a known place of the document; read_json_file finds its line and column. For use inside read_json_file.
struct JsonMistake : std::invalid_argument {
  JsonMistake(std::string pointer, const std::string& why) : std::invalid_argument(why), place(std::move(pointer)) {}
  std::string place;  // JSON pointer, "/frames/3/transform_matrix"
};

// A value and its place in the document. What is missing or has another type is a JsonMistake: "frames[3].file_path: expected a
// text, found a number".
class JsonAt {
 public:
  explicit JsonAt(const nlohmann::json& value, std::string place = {}) : value_(&value), place_(std::move(place)) {}

  const nlohmann::json& value() const { return *value_; }
  bool has(const char* key) const;        // of an object, and not null
  JsonAt at(const char* key) const;       // must be there
  JsonAt operator[](size_t index) const;  // of a list that is long enough
  size_t size() const { return value_->size(); }
  double number() const;  // finite
  std::string text() const;
  const JsonAt& list(const char* of) const;  // must be a list; `of`: what is expected, "a list of frames"
  [[noreturn]] void fail(const std::string& why) const;

 private:
  const nlohmann::json* value_;
  std::string place_;
};

// Places in the text of a JSON document, and what people's mistakes in its syntax mean.
struct TextPlace {
  size_t line = 1, column = 1;
};
TextPlace place_in_text(std::string_view text, size_t byte);
// First byte of the value that a JSON pointer ("/frames/3/w") names; of the deepest value on its way that exists. `text` is a
// well-formed document; nullopt if it is not.
std::optional<size_t> place_of_value(std::string_view text, std::string_view pointer);
// What is wrong at `byte`, where the parser stopped: a trailing comma, a comment, NaN, ... `otherwise`: the parser's own words.
// May move `byte` to where the mistake begins.
std::string syntax_mistake(std::string_view text, size_t& byte, const std::string& otherwise);

}  // namespace vitrine
