#include "core/stereo/shapes_artifact.h"

#include "core/base/file.h"
#include "core/camera/json_file.h"
#include "core/shape/shape_file.h"

namespace vitrine {

ShapeSet read_shapes_file(const fs::path& file) {
  ShapeSet set;
  read_json_file(file, "file of known shapes", [&](const nlohmann::json& j) {
    const nlohmann::json& list = JsonAt(j).at("shapes").value();
    if (!list.is_array()) throw JsonMistake("/shapes", "shapes: expected a list");
    try {
      set = read_shapes(list, file.parent_path());
    } catch (const ShapeMistake& e) {
      throw JsonMistake("/shapes/" + std::to_string(e.entry), e.what());
    }
  });
  return set;
}

ShapeSet read_shapes_artifact(const std::optional<fs::path>& artifact) {
  std::error_code ec;
  if (!artifact || !fs::exists(*artifact / "shapes/shapes.json", ec)) return {};
  return read_shapes_file(*artifact / "shapes/shapes.json");
}

}  // namespace vitrine
