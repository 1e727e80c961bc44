// JSON files of this module: parsed and written with errors that name the file. For *.cpp files only (nlohmann stays out of
// public headers).
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "core/base/json.h"
#include "core/math/vec.h"

namespace vitrine {

// Parses `path` and hands the document to `read`. Syntax errors, missing keys and wrong types become Error{Input} with the
// file and the cause; `format` says in words what the file should be.
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

}  // namespace vitrine
