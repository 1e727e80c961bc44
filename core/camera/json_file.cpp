#include "core/camera/json_file.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/inside.h"
#include "core/base/json_cause.h"
#include "core/base/text_file.h"
#include "core/camera/json_text.h"

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
  // A link to nowhere, or one that leads to itself, is not followed any further.
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
  // Names of files are bytes; those that are not UTF-8 are replaced rather than ending the run.
  write_file(path, document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
}

nlohmann::json json_of(const Vec3d& v) { return {v.x, v.y, v.z}; }

Vec3d vec3_of(const nlohmann::json& j) {
  if (!j.is_array() || j.size() != 3)
    // A structure is not printed: printing descends as deep as a hostile file is nested.
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

}  // namespace vitrine
