#include "core/camera/json_file.h"

#include <cmath>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/inside.h"

namespace vitrine {

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
  const std::string text = read_file(path);
  try {
    read(nlohmann::json::parse(text));
  } catch (const nlohmann::json::exception& e) {
    throw_bad_json(path, format, e.what());
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

}  // namespace vitrine
